"""Figures are left where the user asked, and nowhere else."""

import json
from pathlib import Path

import pytest

from lerobot_llakey.cli.output import write_results


def test_results_are_written_into_a_new_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "a" / "b"
    write_results(folder, {"figure": 1.5})
    assert json.loads((folder / "results.json").read_text()) == {"figure": 1.5}
    assert str(folder) in capsys.readouterr().out


def test_without_a_folder_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_results(None, {"figure": 1.5})
    assert list(tmp_path.iterdir()) == []
