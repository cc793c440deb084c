"""Datasets that grow in parts: killed anywhere, they go on; what is someone else's stays."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from lerobot.datasets.utils import INFO_PATH

from lerobot_llakey.datasets import parts as module
from lerobot_llakey.datasets.parts import DISCARDED, Growth, growing
from lerobot_llakey.errors import FileInTheWayError, LlakeyError

SETTINGS = {"colour": "red"}
Grow = Callable[..., dict[str, int]]


def dataset(root: Path, episodes: int) -> None:
    """As much of a dataset as growing looks at."""
    (root / "meta").mkdir(parents=True)
    (root / INFO_PATH).write_text(json.dumps({"features": {}, "total_episodes": episodes}))


def length(root: Path) -> int:
    return int(json.loads((root / INFO_PATH).read_text())["total_episodes"])


def merge_lengths(target: Path, sources: list[Path], repo_id: str) -> None:
    dataset(target, sum(map(length, sources)))


@pytest.fixture
def made() -> list[str]:
    """Names of the parts that were made, in order."""
    return []


@pytest.fixture
def grow(tmp_path: Path, made: list[str], monkeypatch: pytest.MonkeyPatch) -> Grow:
    """Collects made-up episodes into a/keysteps and b/others, one a part."""
    monkeypatch.setattr(module, "merge_into", merge_lengths)

    def run(episodes: int = 2, root: Path = tmp_path / "a" / "keysteps") -> dict[str, int]:
        targets = {"keysteps": (root, "l/k"), "others": (tmp_path / "b" / "others", "l/o")}
        with growing(SETTINGS, episodes, targets, 1) as growth:
            folders = [growth.parts / f"{i:07d}-{i + 1:07d}" for i in range(growth.begin, episodes)]
            for folder in growth.missing(folders):
                made.append(folder.name)
                for kind in targets:
                    dataset(folder / kind, 1)
                (folder / DISCARDED).write_text(json.dumps({"bad": 1}))
            return growth.finish(folders)

    return run


def lengths(tmp_path: Path) -> list[int]:
    return [length(tmp_path / "a" / "keysteps"), length(tmp_path / "b" / "others")]


def test_datasets_grow_and_leave_nothing_beside_them(tmp_path: Path, grow: Grow, made: list[str]) -> None:
    assert grow(2) == {"bad": 2} and grow(3) == {"bad": 3} and grow(3) == {"bad": 3}
    assert lengths(tmp_path) == [3, 3] and len(made) == 3
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["keysteps"]
    assert [path.name for path in (tmp_path / "b").iterdir()] == ["others"]


OPERATIONS = ("merge_into", "replace_folder", "read_record", "_sweep", "remove", "write_whole")


@pytest.mark.parametrize("operation", OPERATIONS)
@pytest.mark.parametrize("after", [False, True])
def test_killed_anywhere_it_goes_on_and_nothing_is_made_twice(
    tmp_path: Path, grow: Grow, made: list[str], monkeypatch: pytest.MonkeyPatch, operation: str, after: bool
) -> None:
    grow(1)
    real, calls, deadly = getattr(module, operation), 0, 1

    def killed(*arguments, **named):
        nonlocal calls
        calls += 1
        if calls != deadly:
            return real(*arguments, **named)
        if after:
            real(*arguments, **named)
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(module, operation, killed)
        done = False
        while not done:
            calls = 0
            try:
                grow(2)
                done = True
            except KeyboardInterrupt:
                deadly += 1
    assert deadly > 1, "it was killed at least once"
    grow(2)
    assert lengths(tmp_path) == [2, 2]
    assert made == ["0000000-0000001", "0000001-0000002"]
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["keysteps"]


def test_a_cleanup_that_was_killed_half_way_by_an_earlier_version_is_finished(tmp_path: Path, grow: Grow) -> None:
    grow(1)
    parts = tmp_path / "a" / "keysteps.parts"
    (parts / "0000000-0000001").mkdir(parents=True)  # its discarded.json is gone already
    (parts / "settings.json").write_text(json.dumps({"settings": SETTINGS, "begin": 0, "part_size": 1}))
    assert grow(1) == {"bad": 1}
    assert not parts.exists()


def test_a_folder_of_parts_that_no_run_has_begun_is_refused_and_left_alone(tmp_path: Path, grow: Grow) -> None:
    mine = tmp_path / "a" / "keysteps.parts" / "holiday"
    mine.mkdir(parents=True)
    (mine / "beach.png").touch()
    with pytest.raises(FileInTheWayError, match=r"keysteps\.parts.*move it"):
        grow()
    (mine.parent / "settings.json").write_text('{"theme": "dark"}')
    with pytest.raises(LlakeyError, match=r"settings\.json"):
        grow()
    assert (mine / "beach.png").exists()


def test_what_a_person_puts_beside_the_parts_stays(tmp_path: Path, grow: Grow, monkeypatch: pytest.MonkeyPatch) -> None:
    def killed(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Growth, "finish", killed)
        with pytest.raises(KeyboardInterrupt):
            grow()
    mine = tmp_path / "a" / "keysteps.parts" / "notes"
    mine.mkdir()
    (mine / "todo.txt").touch()
    grow()
    assert lengths(tmp_path) == [2, 2] and (mine / "todo.txt").exists()
    assert [path.name for path in mine.parent.iterdir()] == ["notes"]


def test_merging_happens_beside_each_dataset_so_that_they_may_lie_on_different_disks(
    tmp_path: Path, grow: Grow, monkeypatch: pytest.MonkeyPatch
) -> None:
    moved: list[tuple[Path, Path]] = []
    real = Path.replace
    monkeypatch.setattr(Path, "replace", lambda self, other: (moved.append((self, Path(other))), real(self, other))[1])
    grow(1)
    grow(2)
    assert len(moved) > 6 and all(one.parent == other.parent for one, other in moved)


def test_a_root_that_is_a_link_grows_where_it_leads(tmp_path: Path, grow: Grow) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    grow(1, tmp_path / "link")
    grow(2, tmp_path / "link")
    assert length(tmp_path / "real") == 2 and (tmp_path / "link").is_symlink()


def test_more_episodes_wait_until_datasets_are_level_again(
    tmp_path: Path, grow: Grow, monkeypatch: pytest.MonkeyPatch
) -> None:
    real, calls = module.replace_folder, []

    def killed(*arguments):
        calls.append(1)
        if len(calls) == 2:
            raise KeyboardInterrupt
        real(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(module, "replace_folder", killed)
        with pytest.raises(KeyboardInterrupt):
            grow(1)
    with pytest.raises(LlakeyError, match="first repeat its command, which asked for 1 episodes"):
        grow(2)
    grow(1)
    grow(2)
    assert lengths(tmp_path) == [2, 2]
