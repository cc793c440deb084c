"""Folders that appear, or take the place of older ones, whole or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lerobot_llakey.errors import FileInTheWayError, LlakeyError
from lerobot_llakey.files import UNFINISHED, alone_at, reason, remove

_OLD, _ASIDE = ".llakey-old", ".llakey-aside"


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """Give a folder to fill, which appears under the name ``folder`` in one step when the block ends well.

    What an earlier run left unfinished is removed first. A second process that wants the same folder is refused.

    Args:
        folder: must not exist yet, or be empty.

    Yields:
        A folder beside it, on the same file system, that does not exist yet.

    Raises:
        FileInTheWayError: if something stands at ``folder``.
        LlakeyError: if the place cannot be written to, or another process is filling the folder, or it is a mount
            point.
    """
    refuse_occupied(folder)
    unfinished = folder.with_name(f".{folder.name}{UNFINISHED}")
    with alone_at(folder, "place"):
        restore_folder(folder)
        refuse_occupied(folder)
        check_movable(folder)
        remove(unfinished)
        try:
            yield unfinished
            if folder.is_dir():
                folder.rmdir()
            unfinished.replace(folder)
        finally:
            remove(unfinished)


def refuse_occupied(folder: Path) -> None:
    """Refuse a place for a new folder where something stands already.

    Raises:
        FileInTheWayError: if there is a file, a link or a folder with something in it.
    """
    if folder.is_symlink() or (folder.exists() and not (folder.is_dir() and not any(folder.iterdir()))):
        raise FileInTheWayError(f"Expected a folder that does not exist yet, got {folder}; choose another one.")


def check_movable(folder: Path) -> None:
    """Check before work that a folder can be renamed, where there is one, so that another may take its place.

    Raises:
        LlakeyError: if it cannot: it is a mount point, as folders of containers are, or its parent is read-only.
    """
    if not folder.is_dir():
        return
    aside = folder.with_name(f".{folder.name}{_ASIDE}")
    try:
        folder.rename(aside)
        aside.rename(folder)
    except OSError as error:
        raise LlakeyError(
            f"Expected a folder whose place another can take, got {folder} ({reason(error)}), perhaps a mount point; "
            f"name a new folder within it, such as {folder / 'dataset'}."
        ) from error


def replace_folder(fresh: Path, folder: Path) -> None:
    """Let a finished folder take the place of another, or of nothing; :func:`restore_folder` mends a kill in between.

    Args:
        fresh: on the same file system.
        folder: what is there is removed afterwards.
    """
    old = folder.with_name(f".{folder.name}{_OLD}")
    folder.parent.mkdir(parents=True, exist_ok=True)
    if folder.exists():
        folder.replace(old)
    fresh.replace(folder)
    remove(old)


def restore_folder(folder: Path) -> None:
    """Undo what a killed :func:`replace_folder` or :func:`check_movable` left half done."""
    for suffix in (_OLD, _ASIDE):
        old = folder.with_name(f".{folder.name}{suffix}")
        if old.exists() and not folder.exists():
            old.replace(folder)
        remove(old)
