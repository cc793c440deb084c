"""``llakey abilities`` as typed."""

import json
import sys
from pathlib import Path

import pytest
import torch
from lerobot.datasets.dataset_metadata import LeRobotDatasetMetadata

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.cli import abilities
from lerobot_llakey.evaluation.abilities.measure import ABILITIES
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.command.processor_llakey_command import make_llakey_command_pre_post_processors

TINY = {
    **{"vision_width": 16, "vision_layers": 1, "vision_heads": 1, "text_width": 32, "text_layers": 1, "text_heads": 1},
    **{"device": "cpu", "push_to_hub": False, "image_size": 32, "patch_size": 8, "dtype": "float32"},
}


def llakey(monkeypatch: pytest.MonkeyPatch, *options: str) -> None:
    monkeypatch.setattr(sys, "argv", ["llakey abilities", *options])
    abilities.main()


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return fake_keysteps(tmp_path_factory.mktemp("data") / "d", episodes=2, frames=4).root


@pytest.fixture(scope="module")
def checkpoint(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An untrained command policy that knows one instruction."""
    folder = tmp_path_factory.mktemp("policy")
    torch.manual_seed(0)
    config = LlakeyCommandConfig(**TINY, cameras=["front"], instructions=["grasp the red block"])
    LlakeyCommandPolicy(config, dataset_meta=LeRobotDatasetMetadata("me/x", root=data)).save_pretrained(folder)
    for processor in make_llakey_command_pre_post_processors(config):
        processor.save_pretrained(folder)
    return folder


def test_figures_tables_and_plots_are_written(
    checkpoint: Path, data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    options = (f"--policy_path={checkpoint}", "--repo_id=me/x", f"--root={data}")
    llakey(monkeypatch, *options, f"--output_dir={tmp_path / 'out'}")
    names = {"results.json", "abilities.md", "abilities.png", "verbs.png", "confusions.csv", "verbs.csv"}
    assert {path.name for path in (tmp_path / "out").iterdir()} == names
    results = json.loads((tmp_path / "out" / "results.json").read_text())
    assert all("pick_up" in results[ability] and results[ability]["all"]["unparsable"] == 0 for ability in ABILITIES)
    assert "| pick_up" in capsys.readouterr().out


def test_an_unconstrained_policy_has_its_unparsable_answers_counted(
    checkpoint: Path, data: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    llakey(monkeypatch, f"--policy_path={checkpoint}", "--repo_id=me/x", f"--root={data}", "--constrain=false")
    row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("| all samples"))
    assert float(row.split("|")[7]) > 0


def test_the_model_is_asked_about_every_frame_where_that_is_wished(
    checkpoint: Path, data: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    options = (f"--policy_path={checkpoint}", "--repo_id=me/x", f"--root={data}")
    llakey(monkeypatch, *options)
    held = capsys.readouterr().out
    assert "asked about 4 frames, not about 2 in which the arm moved" in held
    row = next(line for line in held.splitlines() if line.startswith("| moving its arm"))
    assert [cell.strip() for cell in row.split("|")[2:4]] == ["2", "100.0"]
    llakey(monkeypatch, *options, "--hold=false")
    assert "in which the arm moved" not in capsys.readouterr().out


def test_a_policy_that_only_acts_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    class Config:
        type = "llakey_action"

    class Acting:
        config = Config()

    with pytest.raises(ValueError, match=r"^Expected a policy that names instructions, got 'llakey_action' in here"):
        abilities.command_policy(Acting(), "here")


def test_a_dataset_without_instructions_is_one_sentence(
    checkpoint: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    fake_keysteps(tmp_path / "d", episodes=1, frames=2, without=(schema.INSTRUCTION,))
    with pytest.raises(SystemExit) as exit_info:
        llakey(monkeypatch, f"--policy_path={checkpoint}", "--repo_id=me/x", f"--root={tmp_path / 'd'}")
    assert exit_info.value.code == 1
    error = capsys.readouterr().err
    assert error.splitlines()[-1].startswith("error: Expected a dataset with the column 'instruction'"), error
