"""``llakey contact-sheet`` writes a picture."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from lerobot_llakey.cli import contact_sheet as verb
from lerobot_llakey.cli.contact_sheet import ContactSheetConfig, run
from lerobot_llakey.errors import LlakeyError


def test_the_page_is_written_in_rgb(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = np.zeros((4, 6, 3), dtype=np.uint8)
    page[..., 0] = 200
    monkeypatch.setattr(verb, "contact_sheet", lambda *_: page)
    run(ContactSheetConfig(tmp_path / "new" / "tasks.png", "open_drawer"))
    np.testing.assert_array_equal(cv2.imread(str(tmp_path / "new" / "tasks.png"))[..., ::-1], page)


def test_another_kind_of_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"whose name ends with \.png, got"):
        run(ContactSheetConfig(tmp_path / "tasks.jpg"))


def test_a_page_that_cannot_be_written_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The folder goes away while the page is drawn, so that no check beforehand can tell."""
    folder = tmp_path / "new"

    def draw(*_: object) -> np.ndarray:
        folder.touch()
        return np.zeros((4, 6, 3), dtype=np.uint8)

    monkeypatch.setattr(verb, "contact_sheet", draw)
    with pytest.raises((OSError, LlakeyError), match=str(folder)):
        run(ContactSheetConfig(folder / "tasks.png", "open_drawer"))
    assert list(tmp_path.iterdir()) == [folder]
