"""Datasets that grow in parts: what is finished, and how parts become one dataset without ever losing an episode."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lerobot.datasets.utils import INFO_PATH

from lerobot_llakey import schema
from lerobot_llakey.datasets.language import write_language
from lerobot_llakey.datasets.merge import merge
from lerobot_llakey.datasets.rewrite import drop
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import write_whole

PARTS_SUFFIX = ".parts"
RECORD = "meta/llakey_collect.json"
"""A file of each collected dataset: its settings, number of episodes, and what was thrown away."""
_SETTINGS = "settings.json"


def begin_parts(settings: Mapping[str, Any], roots: Mapping[str, Path], parts: Path, part_size: int) -> tuple[int, int]:
    """Begin to grow datasets, or go on where a run stopped.

    Args:
        settings: of this run.
        roots: folders of the datasets by kind.
        parts: folder of the parts, created here if missing; it must come from the same settings.
        part_size: episodes a part, unless a run was begun with another number.

    Returns:
        Number of episodes that the datasets hold without the parts, and the episodes a part.

    Raises:
        ValueError: if a folder comes from other settings, is no collected dataset, or the datasets differ in length.
    """
    counts: dict[str, int] = {}
    for kind, root in roots.items():
        old = parts / f"old-{kind}"
        if old.exists() and not root.exists():
            old.replace(root)
        if not _holds_something(root):
            counts[kind] = 0
            continue
        record = read_record(root)
        if record["settings"] != settings:
            raise LlakeyError(
                f"Expected {root} to be collected with {dict(settings)}, got {record['settings']}; choose another "
                "folder."
            )
        counts[kind] = int(record["episodes"])
    begun: dict[str, Any] = {"settings": dict(settings), "begin": min(counts.values()), "part_size": part_size}
    path = parts / _SETTINGS
    if path.exists():
        found = json.loads(path.read_text())
        if found["settings"] != settings:
            raise LlakeyError(
                f"Expected {parts} to be begun with {dict(settings)}, got {found['settings']}; repeat the first "
                "command or delete that folder."
            )
        begun = found
    elif len(set(counts.values())) > 1:
        raise LlakeyError(f"Expected datasets of one length, got {counts}; collect the shorter one by itself.")
    parts.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps(begun))
    return int(begun["begin"]), int(begun["part_size"])


def _holds_something(folder: Path) -> bool:
    return folder.is_dir() and any(folder.iterdir())


def read_record(root: Path) -> dict[str, Any]:
    """What a collected dataset says about its making.

    Raises:
        ValueError: if the folder is not one.
    """
    path = root / RECORD
    if not path.exists():
        raise LlakeyError(f"Expected {root} to be absent or collected by llakey, got another folder; choose a new one.")
    return json.loads(path.read_text())


def _level(folders: Sequence[Path]) -> None:
    """Leave out the columns that came later where not all datasets to be merged were begun with them."""
    features = [set(json.loads((folder / INFO_PATH).read_text())["features"]) for folder in folders]
    lacking = [key for key in schema.LATER_COLUMNS if not all(key in known for known in features)]
    for folder in folders if lacking else ():
        drop(folder, lacking)


def finish(
    settings: Mapping[str, Any],
    episodes: int,
    targets: Mapping[str, tuple[Path, str]],
    folders: Sequence[Path],
    parts: Path,
) -> dict[str, int]:
    """Merge all parts, in order, behind what the datasets hold already, then remove the parts.

    A dataset appears or changes in one step, so a run stopped here loses nothing.

    Args:
        settings: of this run.
        episodes: number of episodes that each dataset must have in the end.
        targets: folder and repo id of the datasets by kind.
        folders: of the parts, each holding one dataset a kind.
        parts: their folder.

    Returns:
        Number of episodes thrown away by reason.
    """
    thrown: Counter[str] = Counter()
    for folder in folders:
        thrown += Counter(json.loads((folder / "thrown.json").read_text()))
    total: dict[str, int] = dict(thrown)
    for kind, (root, repo_id) in targets.items():
        earlier = [root] if _holds_something(root) else []
        if earlier:
            record = read_record(root)
            if record["episodes"] >= episodes:
                total = record["thrown_away"]
                continue
            total = dict(thrown + Counter(record["thrown_away"]))
        merged = parts / f"merged-{kind}"
        shutil.rmtree(merged, ignore_errors=True)
        _level([*earlier, *(folder / kind for folder in folders)])
        merge([*earlier, *(folder / kind for folder in folders)], merged, repo_id)
        if kind == "demonstrations":
            write_language(merged)
        record = {"settings": dict(settings), "episodes": episodes, "thrown_away": total}
        (merged / RECORD).write_text(json.dumps(record, indent=2))
        if earlier:
            root.replace(parts / f"old-{kind}")
        root.parent.mkdir(parents=True, exist_ok=True)
        merged.replace(root)
    shutil.rmtree(parts)
    return total
