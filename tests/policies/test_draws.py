"""A seed repeats a training, and a resumed run goes on as if it had never stopped."""

import random
import shutil
import sys
from pathlib import Path

import pytest
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.scripts import lerobot_train
from safetensors.torch import load_file

from fakes import fake_keysteps
from lerobot_llakey.policies.draws import numpy_generator, seeded_by_step

ACTION = (
    *("view_size=32", "widths=[16,24,32]", "transformer_layers=1", "transformer_heads=2", "text_width=32"),
    *("text_layers=1", "text_buckets=64", "paraphrase_probability=0.9", "colour_jitter=0.2"),
)
COMMAND = (
    *("image_size=32", "patch_size=16", "vision_width=16", "vision_layers=2", "vision_heads=2", "text_width=32"),
    *("text_layers=1", "text_heads=2", "paraphrase_probability=0.5", "history_dropout=0.5"),
)
POLICIES = {
    "llakey_action": [f"--policy.{setting}" for setting in ACTION],
    "llakey_command": [f"--policy.{setting}" for setting in COMMAND],
    "llakey": [f"--policy.action.{setting}" for setting in ACTION]
    + [f"--policy.command.{setting}" for setting in COMMAND],
}


@pytest.fixture(scope="module")
def keysteps(tmp_path_factory: pytest.TempPathFactory) -> LeRobotDataset:
    """Ten samples: three batches an epoch, so that a run of four steps begins a second one."""
    return fake_keysteps(tmp_path_factory.mktemp("keysteps") / "dataset", episodes=2, frames=5)


@pytest.mark.slow
@pytest.mark.parametrize("kind", POLICIES)
def test_a_seed_repeats_a_training_and_a_resumed_run_goes_on(
    kind: str, keysteps: LeRobotDataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def train(*options: object) -> None:
        monkeypatch.setattr(sys, "argv", ["lerobot-train", *map(str, options)])
        lerobot_train.main()

    def weights(name: str, step: int) -> dict[str, torch.Tensor]:
        return load_file(tmp_path / name / f"checkpoints/{step:06}/pretrained_model/model.safetensors")

    common = (
        *(f"--policy.type={kind}", *POLICIES[kind], "--policy.device=cpu", "--policy.push_to_hub=false"),
        *(f"--dataset.repo_id={keysteps.repo_id}", f"--dataset.root={keysteps.root}", "--batch_size=4"),
        *("--num_workers=0", "--steps=4", "--save_freq=2", "--log_freq=1", "--wandb.enable=false"),
    )
    for name, seed in (("first", 5), ("second", 5), ("other", 6)):
        random.seed()  # whatever came before must not matter
        train(*common, f"--seed={seed}", f"--output_dir={tmp_path / name}")
    first = weights("first", 4)
    torch.testing.assert_close(weights("second", 4), first, rtol=1e-4, atol=1e-6)
    assert any(not torch.allclose(value, first[key], atol=1e-4) for key, value in weights("other", 4).items())

    shutil.rmtree(tmp_path / "second/checkpoints/000004")
    saved = tmp_path / "second/checkpoints/000002/pretrained_model/train_config.json"
    random.seed()
    train(f"--config_path={saved}", "--resume=true")
    torch.testing.assert_close(weights("second", 4), first, rtol=1e-4, atol=1e-6)


class Drawing(torch.nn.Linear):
    """Draws in training."""

    def __init__(self) -> None:
        super().__init__(1, 1)

    @seeded_by_step
    def forward(self, count: int) -> list[float]:
        return [*torch.rand(count).tolist(), float(numpy_generator().random())] if self.training else []


def test_draws_follow_python_s_generator_and_leave_pytorch_s_as_it_is() -> None:
    layer = Drawing()
    random.seed(3)
    state = torch.get_rng_state()
    first, second = layer(2), layer(2)
    assert torch.equal(torch.get_rng_state(), state)
    assert len({*first, *second}) == 6
    random.seed(3)
    torch.rand(5)  # as a data loader that begins anew
    assert (layer(2), layer(2)) == (first, second)


def test_nothing_is_drawn_outside_training() -> None:
    layer = Drawing().eval()
    state = random.getstate()
    assert layer(2) == []
    assert random.getstate() == state
