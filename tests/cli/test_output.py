"""Figures are left where the user asked, and nowhere else."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from lerobot_llakey.cli.output import write_png, write_results
from lerobot_llakey.errors import LlakeyError


def test_results_are_written_into_a_new_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "a" / "b"
    write_results(folder, {"figure": 1.5})
    assert json.loads((folder / "results.json").read_text()) == {"figure": 1.5}
    assert str(folder) in capsys.readouterr().out


def test_without_a_folder_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_results(None, {"figure": 1.5})
    assert list(tmp_path.iterdir()) == []


def test_a_picture_keeps_its_colours_and_takes_the_place_of_the_old_one(tmp_path: Path) -> None:
    picture = np.zeros((4, 6, 3), dtype=np.uint8)
    picture[..., 0] = 200
    path = tmp_path / "a" / "page.png"
    for _ in range(2):
        write_png(path, picture)
    np.testing.assert_array_equal(cv2.imread(str(path))[..., ::-1], picture)
    assert list(path.parent.iterdir()) == [path]


def test_what_cannot_be_written_leaves_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device", str(tmp_path))

    monkeypatch.setattr(Path, "write_bytes", full)
    for write in (lambda: write_results(tmp_path, {}), lambda: write_png(tmp_path / "a.png", np.zeros((2, 2, 3)))):
        with pytest.raises(LlakeyError, match="no space left on device"):
            write()
    assert list(tmp_path.iterdir()) == []
