"""Places of datasets are checked before the first episode."""

from pathlib import Path

import pytest

from lerobot_llakey.datasets.places import check_space, claimed, settled
from lerobot_llakey.errors import FileInTheWayError, LlakeyError


def both(one: Path, other: Path) -> dict[str, tuple[Path, str]]:
    return {"demonstrations": (one, "l/d"), "keysteps": (other, "l/k")}


@pytest.mark.parametrize("other", ["a", "a/keysteps", "a/../a", "a.parts", "a.parts/keysteps", "."])
def test_folders_that_are_the_same_or_within_each_other_are_refused(tmp_path: Path, other: str) -> None:
    with pytest.raises(LlakeyError, match="apart from each other"):
        settled(both(tmp_path / "a", tmp_path / other))
    assert list(tmp_path.iterdir()) == []


def test_links_to_folders_are_followed_and_links_to_nowhere_and_files_refused(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    (tmp_path / "file").touch()
    assert settled({"keysteps": (tmp_path / "link", "l/k")})["keysteps"][0] == (tmp_path / "real").resolve()
    with pytest.raises(FileInTheWayError, match=r"dangling, a link to .*nowhere"):
        settled({"keysteps": (tmp_path / "dangling", "l/k")})
    with pytest.raises(FileInTheWayError, match=r"the file .*file;"):
        settled({"keysteps": (tmp_path / "file", "l/k")})
    with pytest.raises(LlakeyError, match="with a name"):
        settled({"keysteps": (Path("/"), "l/k")})


def test_two_runs_that_share_one_folder_of_two_are_kept_apart(tmp_path: Path) -> None:
    with (
        claimed(both(tmp_path / "a", tmp_path / "b")),
        pytest.raises(LlakeyError, match=r"no other run in .*b, .*--root"),
        claimed({"keysteps": (tmp_path / "b", "l/k")}),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_is_too_small_is_said_with_what_is_needed(tmp_path: Path) -> None:
    targets = settled(both(tmp_path / "a", tmp_path / "b"))
    check_space(targets, 1, 1, 128)
    with pytest.raises(LlakeyError, match=r"Expected [0-9.e+]+ GB of free space .*got [0-9.]+ GB"):
        check_space(targets, 10**10, 10**10, 128)
