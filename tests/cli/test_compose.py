"""llakey compose: which paths go with which way, and a split of the shipped checkpoint that composes to it again."""

import sys
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file

from lerobot_llakey.cli import compose

SHIPPED = Path(__file__).parents[2] / "checkpoints/llakey_small"


def _run(monkeypatch: pytest.MonkeyPatch, *options: str) -> None:
    monkeypatch.setattr(sys, "argv", ["llakey compose", *options])
    compose.main()


def test_the_shipped_checkpoint_survives_being_split_and_composed(monkeypatch, tmp_path: Path, capsys) -> None:
    split = ("--split=true", f"--policy_path={SHIPPED}", f"--output_dir={tmp_path / 'parts'}", "--half=true")
    _run(monkeypatch, *split)
    parts = (f"--command_path={tmp_path / 'parts/command'}", f"--action_path={tmp_path / 'parts/action'}")
    _run(monkeypatch, *parts, f"--output_dir={tmp_path / 'both'}", "--half=true")
    before, after = (load_file(folder / "model.safetensors") for folder in (SHIPPED, tmp_path / "both"))
    assert before.keys() == after.keys()
    assert all(torch.equal(before[name], after[name]) for name in before)
    assert f"checkpoint: {tmp_path / 'parts/action'}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--command_path=a"], "Expected --command_path and --action_path with --split=false, got --command_path;"),
        (["--split=true"], "Expected --policy_path with --split=true, got no path;"),
        (["--split=true", "--policy_path=a", "--action_path=b"], "got --action_path and --policy_path;"),
    ],
)
def test_paths_that_do_not_fit_the_way_are_refused(
    options: list[str], message: str, monkeypatch, tmp_path: Path, capsys
) -> None:
    with pytest.raises(SystemExit) as exit_info:
        _run(monkeypatch, f"--output_dir={tmp_path}", *options)
    assert exit_info.value.code == 1
    assert message in capsys.readouterr().err
