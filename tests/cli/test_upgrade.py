"""The verb ``upgrade``."""

import sys
from pathlib import Path

import pytest

from lerobot_llakey.cli import upgrade


def test_it_upgrades_one_folder_into_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    calls: list[tuple[Path, Path]] = []
    monkeypatch.setattr(upgrade, "upgrade", lambda *folders: calls.append(folders))
    monkeypatch.setattr(sys, "argv", ["llakey upgrade", f"--root={tmp_path / 'a'}", f"--output_root={tmp_path / 'b'}"])
    upgrade.main()
    assert calls == [(tmp_path / "a", tmp_path / "b")]
    assert f"dataset: {tmp_path / 'b'}" in capsys.readouterr().out


def test_a_folder_without_a_dataset_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["llakey upgrade", f"--root={tmp_path}", f"--output_root={tmp_path / 'b'}"])
    with pytest.raises(SystemExit):
        upgrade.main()
    assert "Expected a dataset in" in capsys.readouterr().err
