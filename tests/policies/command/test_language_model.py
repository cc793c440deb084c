import pytest
import torch

from fakes_models import write_tiny
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    return str(write_tiny("llava", tmp_path_factory.mktemp("tiny")))


def _step(settings: dict, keysteps, batch: dict) -> tuple[torch.Tensor, dict[str, torch.Tensor], int]:
    """Loss, gradients by name, and bytes that the forward pass kept for the backward pass."""
    quiet = {"history_dropout": 0.0, "shift_pixels": 0, "colour_jitter": 0.0}
    torch.manual_seed(0)
    policy = LlakeyCommandPolicy(LlakeyCommandConfig(**settings, **quiet), dataset_meta=keysteps.meta).train()
    kept = []
    with torch.autograd.graph.saved_tensors_hooks(lambda t: kept.append(t.nbytes) or t, lambda t: t):
        loss, _ = policy.forward(batch)
    forward_kept = sum(kept)
    loss.backward()
    return loss.detach(), {name: p.grad for name, p in policy.named_parameters() if p.grad is not None}, forward_kept


@pytest.mark.parametrize("pretrained", [True, False])
@pytest.mark.parametrize("parts", [None, ["vision"]])
def test_gradient_checkpointing_changes_neither_loss_nor_gradients_and_keeps_less(
    pretrained, parts, tiny, small_settings, keysteps, batch
):
    settings = small_settings | {"train": parts, "model": tiny if pretrained else None}
    loss, gradients, kept = _step(settings, keysteps, batch)
    again, same, kept_less = _step(settings | {"gradient_checkpointing": True}, keysteps, batch)
    assert kept_less < 0.7 * kept
    assert torch.equal(loss, again)
    assert gradients.keys() == same.keys() and gradients
    # Shared weights gather their gradients in another order; a layer that computed otherwise would differ by far more.
    assert all(torch.allclose(gradients[name], same[name], rtol=1e-4, atol=1e-5) for name in gradients)


@pytest.mark.parametrize("pretrained", [True, False])
def test_weights_of_bfloat16_train_are_saved_and_speak_the_same(
    pretrained, tiny, small_settings, keysteps, batch, tmp_path
):
    settings = small_settings | {
        "dtype": "bfloat16",
        "weights_dtype": "bfloat16",
        "model": tiny if pretrained else None,
    }
    policy = LlakeyCommandPolicy(LlakeyCommandConfig(**settings), dataset_meta=keysteps.meta)
    assert {p.dtype for p in policy.model.parameters()} == {torch.bfloat16}
    optimizer = policy.config.get_optimizer_preset().build(policy.get_optim_params())
    for _ in range(5):
        loss, _ = policy.train().forward(batch)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    assert loss.isfinite()
    policy.eval().save_pretrained(tmp_path)
    loaded = LlakeyCommandPolicy.from_pretrained(tmp_path)
    assert {p.dtype for p in loaded.model.parameters()} == {torch.bfloat16}
    assert torch.equal(policy.forward(batch)[0], loaded.forward(batch)[0])
    assert policy.next_instructions(batch) == loaded.next_instructions(batch)


def test_one_view_in_place_of_three(tiny, small_settings, keysteps, batch):
    for model in (None, tiny):
        config = LlakeyCommandConfig(**small_settings | {"model": model, "cameras": ["front"]})
        policy = LlakeyCommandPolicy(config, dataset_meta=keysteps.meta)
        policy.forward(batch)[0].backward()
        front = {key: value for key, value in batch.items() if "images" not in key or key.endswith("images.front")}
        answers = policy.next_instructions(front)
        assert set(answers) <= set(policy.config.instructions)
        assert answers == policy.next_instructions(batch)
