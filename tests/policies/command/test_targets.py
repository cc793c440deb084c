import numpy as np
import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.encoding import Encoder
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.command.pose_text import PoseText
from lerobot_llakey.policies.command.small.tokenizer import WordEncoder, WordTokenizer
from lerobot_llakey.policies.command.targets import ActionTarget, InstructionTarget, make_target


class Spelling(Encoder):
    """One token a character, as many tokenizers have it for digits."""

    pad_id, stop_id = 0, 1

    def prompts(self, images, prompts):
        raise NotImplementedError

    def answer(self, text):
        return [*map(ord, text), self.stop_id]

    def decode(self, ids):
        return "".join(chr(token) for token in ids if token > 1)


class Blind(Spelling):
    """Knows no digits."""

    def answer(self, text):
        return [7 for _ in text.split()] + [self.stop_id]


def encoders(text: PoseText) -> list[Encoder]:
    return [WordEncoder(WordTokenizer(text.numbers), 32, 16), Spelling()]


@pytest.mark.parametrize("index", [0, 1])
def test_every_walk_through_the_trie_is_a_pose_and_every_pose_a_walk(index):
    text = PoseText(40)
    encoder = encoders(text)[index]
    trie = ActionTarget(text).trie(encoder)
    rng = np.random.default_rng(0)
    for _ in range(50):
        ids: list[int] = []
        while following := trie.next_tokens(ids):
            ids.append(int(rng.choice(following)))
        said = encoder.decode(ids)
        text.decode(said)
        assert encoder.answer(said) == ids
    numbers = [f"{rng.integers(size):03d}" for size in text.sizes]
    ids = encoder.answer(" ".join(numbers))
    assert all(token in trie.next_tokens(ids[:place]) for place, token in enumerate(ids))


def test_a_tokenizer_that_cannot_write_numbers_is_refused():
    with pytest.raises(ValueError, match="use target=instruction"):
        ActionTarget(PoseText(4)).trie(Blind())


def test_a_batch_without_actions_is_refused():
    with pytest.raises(ValueError, match="Expected action in the batch"):
        ActionTarget(PoseText()).answers({schema.TASK: ["x"]})


@pytest.fixture
def acting(small_settings, keysteps) -> LlakeyCommandPolicy:
    torch.manual_seed(0)
    settings = small_settings | {"auxiliary_weight": 0.0, "shift_pixels": 0}
    config = LlakeyCommandConfig(**settings, target="action", action_bins=32)
    return LlakeyCommandPolicy(config, dataset_meta=keysteps.meta).eval()


def test_the_settings_choose(small_settings):
    assert isinstance(make_target(LlakeyCommandConfig(**small_settings)), InstructionTarget)
    target = make_target(LlakeyCommandConfig(**small_settings, target="action", action_bins=99))
    assert isinstance(target, ActionTarget) and target.text.bins == 99


@pytest.mark.parametrize("wrong", [{"target": "poem"}, {"target": "action", "constrain": False}])
def test_settings_that_do_not_fit_are_refused(small_settings, wrong):
    with pytest.raises(ValueError, match="target"):
        LlakeyCommandConfig(**small_settings, **wrong)


def test_an_untrained_policy_gives_legal_actions(acting, batch):
    actions = acting.select_action(batch)
    assert actions.shape == (6, schema.ACTION_DIM) and actions.dtype == torch.float32
    low, high = torch.tensor(schema.WORKSPACE).T
    assert ((actions[:, :3] > low) & (actions[:, :3] < high)).all()
    torch.testing.assert_close(actions[:, 3:7].norm(dim=1), torch.ones(6))
    assert set(actions[:, 7:].flatten().tolist()) <= {0.0, 1.0}
    assert acting.predict_action_chunk(batch).shape == (6, 1, schema.ACTION_DIM)


def test_the_loss_falls_and_the_actions_are_learned_without_instructions(acting, keysteps):
    items = [keysteps[index] for index in (0, 11)]
    batch = torch.utils.data.default_collate(items)
    batch = {key: value for key, value in batch.items() if "instruction" not in key}
    optimizer = torch.optim.Adam(acting.parameters(), lr=3e-3)
    losses = []
    for _ in range(120):
        optimizer.zero_grad()
        loss, metrics = acting.forward(batch)
        loss.backward()
        optimizer.step()
        losses.append(loss.item())
        if metrics["instruction_accuracy"] == 1 and loss.item() < 0.1:
            break
    assert losses[-1] < 0.2 * losses[0]
    error = acting.select_action(batch)[:, :3] - batch[schema.ACTION][:, :3]
    assert error.abs().max() < 0.5 / 32 + 1e-6


def test_a_policy_that_acts_names_nothing_and_one_that_names_does_not_act(acting, small_config, keysteps, batch):
    with pytest.raises(ValueError, match="target=action, which acts by itself"):
        acting.next_instructions(batch)
    naming = LlakeyCommandPolicy(small_config, dataset_meta=keysteps.meta)
    with pytest.raises(NotImplementedError, match="compose it"):
        naming.select_action(batch)


def test_samples_count_by_their_weight(small_config, keysteps, batch):
    torch.manual_seed(0)
    policy = LlakeyCommandPolicy(small_config, dataset_meta=keysteps.meta).eval()
    each, _ = policy.forward(batch, reduction="none")
    weights = torch.tensor([6.0, 1, 1, 6, 1, 1])
    weighted, _ = policy.forward(batch | {schema.SAMPLE_WEIGHT: weights[:, None]}, reduction="none")
    torch.testing.assert_close(weighted, each * weights / weights.mean())


@pytest.mark.parametrize("target", ["instruction", "action"])
def test_the_mean_loss_is_the_mean_of_the_samples_losses(small_settings, keysteps, batch, target):
    torch.manual_seed(0)
    policy = LlakeyCommandPolicy(LlakeyCommandConfig(target=target, **small_settings), dataset_meta=keysteps.meta)
    policy.eval()
    # Answers of different lengths, which the two ways of reducing would count differently.
    batch = batch | {schema.INSTRUCTION: ["raise the robotic arm", *batch[schema.INSTRUCTION][1:]]}
    for weights in ({}, {schema.SAMPLE_WEIGHT: torch.tensor([6.0, 1, 0, 6, 1, 1])}):
        each, _ = policy.forward(batch | weights, reduction="none")
        whole, _ = policy.forward(batch | weights)
        assert each.shape == (6,) and each.mean().item() == pytest.approx(whole.item(), rel=1e-5)


def test_a_saved_policy_acts_the_same(acting, batch, tmp_path):
    acting.save_pretrained(tmp_path)
    loaded = LlakeyCommandPolicy.from_pretrained(tmp_path)
    torch.testing.assert_close(loaded.select_action(batch), acting.select_action(batch))
