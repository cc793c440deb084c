"""Where datasets grow: places that are checked before the first episode is made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from itertools import permutations
from pathlib import Path

from lerobot_llakey import schema
from lerobot_llakey.errors import FileInTheWayError, LlakeyError
from lerobot_llakey.files import alone_at, check_writable
from lerobot_llakey.folders import restore_folder

PARTS_SUFFIX = ".parts"
_EPISODE_BYTES = {"demonstrations": 0.93e6, "keysteps": 0.44e6}
"""Of an episode at the default picture size, over all tasks (``llakey bench --part=collect``)."""

Places = Mapping[str, tuple[Path, str]]
"""Folder and repo id of datasets by kind."""


def settled(targets: Places) -> Places:
    """The targets with links followed, none of them in another's way.

    Raises:
        FileInTheWayError: if a file or a link to nowhere stands at one.
        LlakeyError: if a folder has no name, or two are the same or lie within each other.
    """
    found: dict[str, tuple[Path, str]] = {}
    for kind, (root, repo_id) in targets.items():
        if root.is_symlink() and not root.exists():
            raise FileInTheWayError(
                f"Expected a folder for the {kind}, got {root}, a link to {root.readlink()}, which does not exist; "
                "make that folder or choose another one."
            )
        if root.exists() and not root.is_dir():
            raise FileInTheWayError(f"Expected a folder for the {kind}, got the file {root}; choose another folder.")
        folder = root.resolve()
        if not folder.name:
            raise LlakeyError(f"Expected a folder with a name for the {kind}, got {root}; choose a folder within it.")
        found[kind] = folder, repo_id
    taken = {kind: root for kind, (root, _) in found.items()}
    taken["parts"] = parts_of(found)
    for (one, root), (other, within) in permutations(taken.items(), 2):
        if within.is_relative_to(root):
            raise LlakeyError(
                f"Expected folders apart from each other, got {within} for the {other} and {root} for the {one}; "
                "choose another folder for one of them."
            )
    return found


def parts_of(targets: Places) -> Path:
    """The folder in which parts are made, beside the first dataset."""
    return Path(f"{next(iter(targets.values()))[0]}{PARTS_SUFFIX}")


@contextmanager
def claimed(targets: Places) -> Iterator[None]:
    """Keep all other runs from these folders, and put back what a killed one left renamed.

    Raises:
        LlakeyError: if another run is growing one of them, or one cannot be written to.
    """
    with ExitStack() as stack:
        for root, _ in targets.values():
            stack.enter_context(alone_at(root))
        for root, _ in targets.values():
            restore_folder(root)
        yield


def check_space(targets: Places, missing: int, total: int, image_size: int) -> None:
    """Check that the disks hold what will be written: the parts, and then the datasets made of them.

    Args:
        targets: settled.
        missing: number of episodes to be made.
        total: number of episodes in the end.
        image_size: pixels of height and width.

    Raises:
        LlakeyError: if one does not, or cannot be written to.
    """
    scale = (image_size / schema.IMAGE_SIZE) ** 2
    each = {kind: _EPISODE_BYTES[kind] * scale for kind in targets}
    parts = parts_of(targets)
    held_by_parts = int(missing * sum(each.values()))
    check_writable(parts, held_by_parts)
    for kind, (root, _) in targets.items():
        beside = held_by_parts if root.parent == parts.parent else 0
        check_writable(root.parent, beside + int(total * each[kind]))
