"""Every family of models: from a folder on disk to training, answers, and a checkpoint that stands alone."""

import shutil

import pytest
import torch

from fakes_models import TINY, write_tiny
from lerobot_llakey import schema
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.inputs import read_prompts
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy


@pytest.mark.parametrize("family", TINY)
def test_it_learns_answers_and_is_saved(family, keysteps, tmp_path):
    folder = write_tiny(family, tmp_path / "model")
    config = LlakeyCommandConfig(
        device="cpu", model=str(folder), dtype="float32", history_dropout=0.0, shift_pixels=0, colour_jitter=0.0
    )
    policy = LlakeyCommandPolicy(config, dataset_meta=keysteps.meta)
    batch = torch.utils.data.default_collate([keysteps[index] for index in (0, 5)])
    optimizer = torch.optim.AdamW(policy.get_optim_params(), lr=1e-2)
    losses = []
    while len(losses) < 100 and (not losses or losses[-1] > 0.15):
        loss, _ = policy.train().forward(batch)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(loss.item())
    assert losses[-1] < 0.2 * losses[0]

    assert policy.next_instructions(batch) == batch[schema.INSTRUCTION]
    policy.config.constrain = False
    free = policy.next_instructions(batch)

    policy.save_pretrained(tmp_path / "saved")
    shutil.rmtree(folder)
    loaded = LlakeyCommandPolicy.from_pretrained(tmp_path / "saved")
    assert torch.equal(policy.eval().forward(batch)[0], loaded.forward(batch)[0])
    assert loaded.next_instructions(batch) == free


@pytest.mark.parametrize("family", TINY)
def test_no_token_of_an_answer_sees_the_next(family, tmp_path):
    model = str(write_tiny(family, tmp_path))
    config = LlakeyCommandConfig(
        device="cpu", model=model, dtype="float32", cameras=["left_shoulder", "front", "wrist"]
    )
    policy = LlakeyCommandPolicy(config).eval()
    batch = {key: torch.rand(2, 3, 32, 32) for key in config.image_keys} | {schema.TASK: ["grasp the red block"] * 2}
    answers = ["grasp the red block", "grasp the red lid"]
    inputs, labels = policy.encoder.with_answers(
        torch.stack([batch[key] for key in config.image_keys], 1)[:1].expand(2, -1, -1, -1, -1),
        read_prompts(batch, policy.config),
        answers,
    )
    length = labels.shape[1]
    same = int((labels[0] == labels[1]).long().cumprod(0).sum())
    assert 0 < same < length
    hidden = policy.model.model(**inputs, use_cache=False).last_hidden_state[:, -length - 1 :]
    assert torch.allclose(hidden[0, : same + 1], hidden[1, : same + 1], atol=1e-5)
    assert not torch.allclose(hidden[0, same + 1], hidden[1, same + 1], atol=1e-3)
