"""Datasets that grow in parts: what is finished, and how parts become one dataset without ever losing an episode."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from uuid import uuid4

from lerobot_llakey.datasets.collect_record import RECORD, read_record
from lerobot_llakey.datasets.merge import merge_into
from lerobot_llakey.datasets.places import Places, claimed, parts_of, settled
from lerobot_llakey.errors import FileInTheWayError, LlakeyError
from lerobot_llakey.files import UNFINISHED, reading, remove, write_whole
from lerobot_llakey.folders import check_movable, replace_folder

DISCARDED = "discarded.json"
"""The last file of a part to be written: number of episodes discarded by reason."""
_SETTINGS = "settings.json"
_UNWRITTEN = f".settings{UNFINISHED}.json"
_MADE = re.compile(r"([0-9]{7}-[0-9]{7}|[a-z_]+-[0-9]{6})|unfinished-([0-9]{7}-[0-9]{7}|[a-z_]+-[0-9]{6})-[0-9]+")
"""Names of what is made in the folder of the parts; nothing else is ever removed from it."""


@dataclass(frozen=True)
class Growth:
    """Datasets that are growing.

    Attributes:
        settings: of this run.
        episodes: number of episodes that each dataset has in the end.
        targets: folder and repo id of the datasets by kind.
        parts: folder of the parts.
        begin: number of episodes that the datasets hold without the parts.
        part_size: episodes a part.
    """

    settings: Mapping[str, Any]
    episodes: int
    targets: Places
    parts: Path
    begin: int
    part_size: int

    def missing(self, planned: Sequence[Path]) -> list[Path]:
        """The parts that are still to be made; what else was made in their folder, and is not planned, is removed.

        Raises:
            LlakeyError: if a dataset could not take its place in the end.
        """
        whole = [folder for folder in planned if (folder / DISCARDED).exists()]
        _sweep(self.parts, keep=whole)
        for root, _ in self.targets.values() if planned else ():
            check_movable(root)
        return [folder for folder in planned if folder not in whole]

    def require(self, planned: Sequence[Path]) -> None:
        """Check, once they are made, that all parts are where they should be.

        Raises:
            LlakeyError: if one is not: another machine made it, in a folder of its own.
        """
        there = {path.name for path in self.parts.iterdir() if (path / DISCARDED).exists()}
        if absent := [folder.name for folder in planned if folder.name not in there]:
            raise LlakeyError(
                f"Expected all parts in {self.parts} when they are made, got none of {len(absent)}, such as "
                f"{absent[0]}; choose a folder that all machines share."
            )

    def finish(self, folders: Sequence[Path]) -> dict[str, int]:
        """Merge all parts, in order, behind what the datasets hold already, then remove the parts.

        A dataset appears or changes in one step, so a run stopped here loses nothing.

        Args:
            folders: of the parts, each holding one dataset a kind.

        Returns:
            Number of episodes discarded by reason.
        """
        discarded: Counter[str] = Counter()
        for folder in folders:
            discarded += Counter(json.loads((folder / DISCARDED).read_text()))
        total: dict[str, int] = dict(discarded)
        for kind, (root, repo_id) in self.targets.items():
            earlier = [root] if _holds_something(root) else []
            if earlier:
                record = read_record(root)
                if record["episodes"] >= self.episodes:
                    total = record["discarded"]
                    continue
                total = dict(discarded + Counter(record["discarded"]))
            sources = [*earlier, *(folder / kind for folder in folders)]
            merged = root.with_name(f".{root.name}{UNFINISHED}")  # beside its own dataset: on the same file system
            remove(merged)
            merge_into(merged, sources, repo_id)
            record = {"settings": dict(self.settings), "episodes": self.episodes, "discarded": total}
            (merged / RECORD).write_text(json.dumps(record, indent=2))
            replace_folder(merged, root)
        _clear(self.parts)
        return total


@contextmanager
def new_part(folder: Path) -> Iterator[Path]:
    """Give a folder to fill, which becomes the part ``folder`` in one step when the block ends well.

    Two processes may make the same part, as where a cluster gave one up that was only out of reach: their episodes are
    the same, so the first one counts.

    Yields:
        A folder beside it that no other process, on any machine, uses; what a killed one left is removed by the next
        run.
    """
    fresh = folder.with_name(f"unfinished-{folder.name}-{uuid4().int}")
    yield fresh
    try:
        fresh.replace(folder)
    except OSError:
        if not (folder / DISCARDED).exists():
            raise
        remove(fresh)


@contextmanager
def growing(settings: Mapping[str, Any], episodes: int, targets: Places, part_size: int) -> Iterator[Growth]:
    """Begin to grow datasets, or go on where a run stopped; no other run can meanwhile.

    Args:
        settings: of this run.
        episodes: number of episodes that each dataset must have in the end.
        targets: folder and repo id of the datasets by kind.
        part_size: episodes a part, unless a run was begun with another number.

    Raises:
        LlakeyError: if a folder comes from other settings, is no collected dataset, cannot be written to or is being
            grown by another run, or the datasets differ in length.
    """
    targets = settled(targets)
    parts = parts_of(targets)
    with claimed(targets):
        counts = {kind: _count(settings, root) for kind, (root, _) in targets.items()}
        begun = _read_begun(parts)
        if begun is not None and begun.get("finished"):  # killed while it cleaned up
            _clear(parts)
            begun = None
        if min(counts.values()) >= episodes:
            begin = {"begin": episodes, "part_size": part_size}
        elif begun is not None:
            begin = _going_on(begun, settings, episodes, counts, parts)
        elif len(set(counts.values())) > 1:
            raise LlakeyError(f"Expected datasets of one length, got {counts}; collect the shorter one by itself.")
        else:
            begin = {"begin": min(counts.values()), "part_size": part_size}
        parts.mkdir(parents=True, exist_ok=True)
        write_whole(parts / _SETTINGS, json.dumps({"settings": dict(settings), **begin}))
        yield Growth(settings, episodes, targets, parts, begin["begin"], begin["part_size"])


def _count(settings: Mapping[str, Any], root: Path) -> int:
    """Episodes that a dataset holds already."""
    if not _holds_something(root):
        return 0
    record = read_record(root)
    if record["settings"] != settings:
        raise LlakeyError(
            f"Expected {root} to be collected with {dict(settings)}, got {record['settings']}; choose another folder."
        )
    return int(record["episodes"])


def _read_begun(parts: Path) -> dict[str, Any] | None:
    """How a run was begun that was stopped since, None where there was none.

    Raises:
        FileInTheWayError: if something stands there that no such run has made.
    """
    path = parts / _SETTINGS
    if parts.is_dir() and not parts.is_symlink() and path.is_file():
        with reading(path, "record of a run"):
            begun: dict[str, Any] = json.loads(path.read_text())
            _ = begun["settings"], int(begun["begin"]), int(begun["part_size"])
        return begun
    ours = not parts.is_symlink() and (not parts.exists() or parts.is_dir())
    if not ours or (parts.is_dir() and any(file.name != _UNWRITTEN for file in parts.iterdir())):
        raise FileInTheWayError(
            f"Expected nothing at {parts}, where parts are collected, got something that no run of llakey has begun; "
            "move it, or choose another folder for the dataset."
        )
    return None


def _going_on(
    begun: Mapping[str, Any], settings: Mapping[str, Any], episodes: int, counts: Mapping[str, int], parts: Path
) -> dict[str, int]:
    if begun["settings"] != settings:
        raise LlakeyError(
            f"Expected {parts} to be begun with {dict(settings)}, got {begun['settings']}; repeat the first command or "
            "delete that folder."
        )
    begin = {key: int(begun[key]) for key in ("begin", "part_size")}
    if grown := [count for count in counts.values() if begin["begin"] < count < episodes]:
        raise LlakeyError(
            f"Expected datasets of one length, got {dict(counts)} from a run that was stopped while it merged; first "
            f"repeat its command, which asked for {max(grown)} episodes over all tasks."
        )
    return begin


def _holds_something(folder: Path) -> bool:
    return folder.is_dir() and any(folder.iterdir())


def _sweep(parts: Path, keep: Sequence[Path] = ()) -> None:
    """Remove what was made in the folder of the parts, but for some of it."""
    for path in parts.iterdir():
        if path.is_dir() and path not in keep and _MADE.fullmatch(path.name):
            remove(path)


def _clear(parts: Path) -> None:
    """Remove the folder of the parts; killed in between, the next run goes on with that."""
    begun = json.loads((parts / _SETTINGS).read_text())
    write_whole(parts / _SETTINGS, json.dumps(begun | {"finished": True}))
    _sweep(parts)
    remove(parts / _UNWRITTEN)
    remove(parts / _SETTINGS)
    if not any(parts.iterdir()):  # what someone else put there stays
        parts.rmdir()
