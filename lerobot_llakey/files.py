"""Files that appear whole or not at all, and folders that one process at a time may change."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import resources
from pathlib import Path

from filelock import FileLock, Timeout

from lerobot_llakey.errors import FileInTheWayError, LlakeyError, MissingFileError, said

LOCK = ".lock"
UNFINISHED = ".llakey-unfinished"
"""In the names of what is being written."""
_UNREADABLE = (OSError, ValueError, LookupError, TypeError, RecursionError)
"""What Python raises at files of another format; libraries that read files add errors of their own classes."""
_FAULTS_OF = ("builtins", "lerobot_llakey")
"""Whose other errors are faults of the program."""


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a path to write to, whose file takes the place of ``path`` in one step when the block ends well.

    Args:
        path: the final file; its folder is made where it is missing.

    Yields:
        A path beside it with the same suffix, removed again if the block raises.

    Raises:
        LlakeyError: if the folder cannot be written to or the disk is full.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(f".{path.stem}{UNFINISHED}{path.suffix}")
    try:
        yield fresh
        _flush(fresh)
        fresh.replace(path)
    except OSError as error:
        raise LlakeyError(f"Expected to write {path}, got refused ({reason(error)}); choose another place.") from error
    finally:
        fresh.unlink(missing_ok=True)


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file as a whole or not at all, text in UTF-8.

    Raises:
        LlakeyError: if the folder cannot be written to or the disk is full.
    """
    with replacing(path) as fresh:
        fresh.write_bytes(content.encode() if isinstance(content, str) else content)


@contextmanager
def alone_in(folder: Path, option: str = "--output_dir") -> Iterator[None]:
    """Keep other processes out of a folder; the system lifts this by itself when the process ends, however it ends.

    Args:
        folder: made where it is missing; a file called ``.lock`` in it is locked.
        option: what an error advises to change.

    Raises:
        LlakeyError: if another process is in it, or it cannot be written to.
    """
    check_writable(folder)
    folder.mkdir(parents=True, exist_ok=True)
    with _locked(folder / LOCK, folder, option):
        yield


@contextmanager
def alone_at(folder: Path, option: str = "--root") -> Iterator[None]:
    """Keep other processes from making or replacing a folder: as :func:`alone_in`, with the lock beside it.

    Raises:
        LlakeyError: if another process is at it, or it cannot be written to.
    """
    check_writable(folder)
    with _locked_beside(folder, option):
        yield


@contextmanager
def alone_with(file: Path, option: str) -> Iterator[None]:
    """Keep other processes from changing a file: as :func:`alone_at`, for a file that may be there already.

    Raises:
        LlakeyError: if another process has it, a folder stands in its place, or its folder cannot be written to.
    """
    if file.is_dir():
        raise FileInTheWayError(f"Expected {option} to be a file, got the folder {file}; name a file in it.")
    with _locked_beside(file, option):
        yield


def check_writable(folder: Path, needed_bytes: int = 0) -> None:
    """Check before work that a folder can be made or written to; makes nothing.

    Args:
        folder: need not exist.
        needed_bytes: that will be written to it, as far as is known.

    Raises:
        LlakeyError: if a file stands in the way, writing is not allowed, or the disk has not enough space left.
    """
    standing = next(place for place in (folder, *folder.absolute().parents) if place.exists() or place.is_symlink())
    if not standing.is_dir():
        raise LlakeyError(f"Expected a place for the folder {folder}, got {standing}, which is no folder; move it.")
    probe = standing / f".llakey-probe-{os.getpid()}"
    try:
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise LlakeyError(
            f"Expected to write into {standing}, got refused ({reason(error)}); choose another place for {folder}."
        ) from error
    free = shutil.disk_usage(standing).free
    if free < needed_bytes:
        raise LlakeyError(
            f"Expected {needed_bytes / 1e9:.1f} GB of free space for {folder}, got {free / 1e9:.1f} GB; free some or "
            "choose another place."
        )


@contextmanager
def reading(path: Path, kind: str = "file") -> Iterator[None]:
    """Say which file is missing or broken where a library reads it and gives up in words of its own.

    Args:
        path: the file or folder that the block reads.
        kind: what it should be, as an error says it: "JSON file", "checkpoint", "dataset".

    Raises:
        MissingFileError: if it is not there, or something that it needs is not.
        LlakeyError: if it cannot be read: cut off, of another format, forbidden.
    """
    try:
        if not path.exists():
            raise MissingFileError(f"Expected a {kind} at {path}, found none; check the path.")
        yield
    except LlakeyError:
        raise
    except FileNotFoundError as error:
        lacking = error.filename or said(error)
        raise MissingFileError(
            f"Expected a whole {kind} at {path}, got one that lacks a file ({lacking}); fetch or make it anew."
        ) from error
    except MemoryError as error:
        raise LlakeyError(
            f"Expected a {kind} at {path} that fits into memory, got one that does not; check or make it anew."
        ) from error
    except Exception as error:
        if not isinstance(error, _UNREADABLE) and type(error).__module__.partition(".")[0] in _FAULTS_OF:
            raise
        told = said(error, 200) or type(error).__name__
        raise LlakeyError(
            f"Expected a readable {kind} at {path}, got one that is broken ({type(error).__name__}: {told}); fetch or "
            "make it anew."
        ) from error


def remove(path: Path) -> None:
    """Remove a file, a link or a folder with all that is in it, where there is one; a link's target stays."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def reason(error: OSError) -> str:
    """Why the system refused, without the path."""
    return (error.strerror or str(error) or type(error).__name__).lower()


def _flush(path: Path) -> None:
    with path.open("rb") as file:
        os.fsync(file.fileno())


@contextmanager
def _locked_beside(path: Path, option: str) -> Iterator[None]:
    check_writable(path.parent)
    path.parent.mkdir(parents=True, exist_ok=True)
    file = path.with_name(f".{path.name}{LOCK}")
    with _locked(file, path, option):
        try:
            yield
        finally:
            with suppress(OSError):  # removed while it is held: who opened it before then finds it gone, and is refused
                file.unlink()


@contextmanager
def _locked(file: Path, folder: Path, option: str) -> Iterator[None]:
    lock = FileLock(file)
    try:
        lock.acquire(timeout=0)
    except Timeout as error:
        raise LlakeyError(
            f"Expected no other run in {folder}, got one that is still going; wait for it or give another {option}."
        ) from error
    except OSError as error:
        raise LlakeyError(
            f"Expected to write {file}, got refused ({reason(error)}); choose another {option}."
        ) from error
    try:
        yield
    finally:
        lock.release()


def packaged(name: str) -> str:
    """A text that lies beside the package in a clone, and inside it once installed.

    Args:
        name: from that folder on, such as ``dataset_cards/llakey_dataset.md``.
    """
    package = Path(str(resources.files("lerobot_llakey")))
    inside = package / name
    return (inside if inside.is_file() else package.parent / name).read_text(encoding="utf-8")
