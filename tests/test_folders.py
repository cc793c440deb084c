"""Folders that take a place whole or not at all, and places where that could not be."""

import errno
from pathlib import Path

import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.folders import check_movable, new_folder, replace_folder, restore_folder


@pytest.fixture
def mounted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Folders called "mounted" cannot be renamed, as mount points cannot."""
    rename = Path.rename

    def refusing(self: Path, target: Path) -> Path:
        if self.name == "mounted":
            raise OSError(errno.EBUSY, "Device or resource busy", str(self), None, str(target))
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", refusing)


def test_a_mount_point_is_refused_before_work(tmp_path: Path, mounted: None) -> None:
    place = tmp_path / "mounted"
    check_movable(place)  # nothing there yet
    place.mkdir()
    with pytest.raises(LlakeyError, match=r"busy.*mount point.*mounted/dataset"), new_folder(place):
        pytest.fail("work was begun")
    assert [path.name for path in tmp_path.iterdir()] == ["mounted"]


def test_a_folder_that_can_be_moved_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    check_movable(tmp_path / "a")
    assert [path.name for path in tmp_path.iterdir()] == ["a"] and (tmp_path / "a" / "b").is_dir()


@pytest.mark.parametrize("kills", range(4))
def test_a_folder_is_replaced_or_can_be_restored_wherever_it_is_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kills: int
) -> None:
    folder, fresh = tmp_path / "a", tmp_path / "b"
    for place in (folder, fresh):
        place.mkdir()
        (place / place.name).touch()
    steps = 0

    def counted(real):
        def step(*arguments):
            nonlocal steps
            steps += 1
            if steps > kills:
                raise KeyboardInterrupt
            return real(*arguments)

        return step

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", counted(Path.replace))
        patch.setattr("lerobot_llakey.folders.remove", counted(__import__("lerobot_llakey.folders").folders.remove))
        try:
            replace_folder(fresh, folder)
        except KeyboardInterrupt:
            assert steps == kills + 1 <= 3
    restore_folder(folder)
    assert [path.name for path in folder.iterdir()] == (["a"] if kills < 2 else ["b"])
    assert sorted(path.name for path in tmp_path.iterdir()) == (["a", "b"] if kills < 2 else ["a"])
