"""The action policy through LeRobot's own training command, on a made-up dataset."""

import sys
from pathlib import Path

import pytest
from lerobot.scripts import lerobot_train

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy


def arguments(root, output):
    small = (
        "--policy.widths=[16,24,32] --policy.transformer_layers=1 --policy.transformer_heads=2 --policy.view_size=64"
    )
    return [
        *("lerobot-train", "--policy.type=llakey_action", "--policy.device=cpu", "--policy.push_to_hub=false"),
        *("--dataset.repo_id=llakey/fake_keysteps", f"--dataset.root={root}", f"--output_dir={output}"),
        *("--steps=2", "--batch_size=4", "--num_workers=0", "--save_freq=2", "--log_freq=1", "--wandb.enable=false"),
        *small.split(),
    ]


def test_lerobot_train_trains_and_saves(tmp_path, monkeypatch):
    dataset = fake_keysteps(tmp_path / "data")
    monkeypatch.setattr(sys, "argv", arguments(tmp_path / "data", tmp_path / "run"))
    lerobot_train.main()
    policy = LlakeyActionPolicy.from_pretrained(tmp_path / "run/checkpoints/last/pretrained_model")
    assert policy.training_step.item() == 2
    row = {key: value[None] if hasattr(value, "ndim") else [value] for key, value in dataset[0].items()}
    assert policy.select_action(row).shape == (1, schema.ACTION_DIM)


def test_lerobot_train_refuses_a_dataset_without_instructions(tmp_path, monkeypatch):
    fake_keysteps(tmp_path / "data", episodes=1, frames=2, without=(schema.INSTRUCTION,))
    monkeypatch.setattr(sys, "argv", arguments(tmp_path / "data", tmp_path / "run"))
    with pytest.raises(ValueError, match="without instruction columns"):
        lerobot_train.main()


@pytest.mark.parametrize("recipe", ["action_rvt", "action_rvt2", "action_rvt_baseline"])
def test_the_published_recipes_train_and_come_back(recipe, tmp_path, monkeypatch):
    dataset = fake_keysteps(tmp_path / "data", episodes=1)
    config = Path(__file__).parents[3] / "configs" / f"{recipe}.yaml"
    small = "--policy.view_size=24 --policy.patch_size=4 --policy.token_width=32 --policy.transformer_layers=2"
    arguments = [
        *("lerobot-train", f"--config_path={config}", f"--dataset.root={tmp_path / 'data'}", "--policy.device=cpu"),
        *(f"--output_dir={tmp_path / 'run'}", "--steps=1", "--save_freq=1", "--batch_size=2", "--num_workers=0"),
        *("--policy.transformer_heads=2", *small.split()),
    ]
    monkeypatch.setattr(sys, "argv", arguments)
    lerobot_train.main()
    policy = LlakeyActionPolicy.from_pretrained(tmp_path / "run/checkpoints/last/pretrained_model")
    assert policy.config.use_timestep == (recipe == "action_rvt_baseline")
    row = {key: value[None] if hasattr(value, "ndim") else [value] for key, value in dataset[0].items()}
    assert policy.select_action(row).isfinite().all()
