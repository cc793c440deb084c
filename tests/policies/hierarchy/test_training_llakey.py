"""The hierarchy in LeRobot's own training loop: from scratch, resumed, and onwards from saved checkpoints."""

import sys
from pathlib import Path

import pytest
import torch
from lerobot.scripts import lerobot_train
from safetensors.torch import load_file


@pytest.fixture
def train(keysteps, monkeypatch, tmp_path: Path):
    """Runs lerobot-train with options and gives the folder of the last checkpoint."""

    def run(name: str, *options: str) -> Path:
        own = (
            f"--dataset.repo_id={keysteps.repo_id}",
            f"--dataset.root={keysteps.root}",
            f"--output_dir={tmp_path / name}",
            "--policy.device=cpu",
            "--policy.push_to_hub=false",
            *("--batch_size=4", "--num_workers=0", "--log_freq=1", "--env_eval_freq=0"),
        )
        monkeypatch.setattr(sys, "argv", ["lerobot-train", *options, *own])
        lerobot_train.main()
        return tmp_path / name / "checkpoints/last/pretrained_model"

    return run


def _weights(folder: Path) -> dict[str, torch.Tensor]:
    return load_file(folder / "model.safetensors")


def _changed(before: Path, after: Path) -> set[str]:
    """Which parts' weights differ."""
    first, second = _weights(before), _weights(after)
    assert first.keys() == second.keys()
    return {key.split(".")[0] for key in first if not torch.equal(first[key], second[key])}


def test_trains_both_parts_goes_on_and_loads(train, saved: Path, monkeypatch) -> None:
    onwards = train("onwards", f"--policy.path={saved}", "--steps=2", "--save_freq=1")
    assert _changed(saved, onwards) == {"command", "action"}
    half = onwards.parent.parent / "000001/pretrained_model"
    monkeypatch.setattr(
        sys, "argv", ["lerobot-train", f"--config_path={half / 'train_config.json'}", "--resume=true", "--steps=3"]
    )
    lerobot_train.main()
    last = onwards.parent.parent / "last/pretrained_model"
    assert (last.parent / "training_state").is_dir()
    assert last.resolve().parent.name == "000003"
    assert _changed(half, last) == {"command", "action"}


@pytest.mark.parametrize("part", ["command", "action"])
def test_trains_one_part_of_a_composition_and_leaves_the_other_as_it_is(
    part: str, train, make_tiny, tmp_path: Path
) -> None:
    parts = make_tiny()
    parts.command.save_pretrained(tmp_path / "command")
    parts.action.save_pretrained(tmp_path / "action")
    parts.save_pretrained(tmp_path / "before")
    paths = (f"--policy.command_path={tmp_path / 'command'}", f"--policy.action_path={tmp_path / 'action'}")
    frozen = {"command": "action", "action": "command"}[part]
    after = train("after", "--policy.type=llakey", *paths, f"--policy.train_{frozen}=false", "--steps=2")
    assert _changed(tmp_path / "before", after) == {part}


def test_trains_from_scratch(train) -> None:
    from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy

    sizes = (
        *("--policy.command.image_size=32", "--policy.command.patch_size=16", "--policy.command.text_layers=1"),
        *("--policy.action.view_size=32", "--policy.action.widths=[16,24,32]", "--policy.action.transformer_layers=1"),
        *("--policy.action.transformer_heads=2", "--policy.action.text_width=32"),
    )
    folder = train("scratch", "--policy.type=llakey", *sizes, "--steps=1")
    loaded = LlakeyPolicy.from_pretrained(folder)
    assert loaded.command.config.text_layers == 1
    assert "grasp the" in " ".join(loaded.command.config.instructions)
