"""A folder's results are of one setting: what a table was begun with is written down, and held against later runs."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.files import reading, write_whole
from lerobot_llakey.saved.folder import find_checkpoint, require_file

_FILE, _BLOCK = "settings.json", 1 << 20


def settings_of(plan: Plan, rows: Sequence[Row], missing: Mapping[str, str]) -> dict[str, Any]:
    """All that the results depend on.

    Args:
        plan: the protocol.
        rows: of the table.
        missing: names of the rows that cannot be run, with the reason.
    """
    described = {
        row.name: row.described() | {"weights": None if row.name in missing else fingerprint(row)} for row in rows
    }
    # Through JSON once, so that tuples and lists compare as they will when read again.
    return dict(json.loads(json.dumps({"plan": asdict(plan), "rows": described})))


def fingerprint(row: Row) -> str:
    """A digest of all files of the row's checkpoints, which changes with any weight or setting in them.

    Raises:
        MissingFileError: if a checkpoint is missing.
        LlakeyError: if it is broken, or cannot be fetched.
    """
    digest = hashlib.sha256()
    for path in row.paths:
        folder = find_checkpoint(path)
        for file in sorted(folder.rglob("*")):
            if not file.is_dir() and file.suffix != ".md":
                require_file(file)
                digest.update(str(file.relative_to(folder)).encode())
                with file.open("rb") as stream:
                    while block := stream.read(_BLOCK):
                        digest.update(block)
    return digest.hexdigest()


def claim(folder: Path, settings: dict[str, Any]) -> None:
    """Begin a table in a folder, or go on with one begun with the same settings.

    A row whose checkpoint was missing before may have one now.

    Raises:
        LlakeyError: if the folder's table was begun with other settings, or their record is broken.
    """
    if (folder / _FILE).exists():
        require_settings(folder, settings)
    write_whole(folder / _FILE, json.dumps(settings, indent=2))


def require_settings(folder: Path, settings: dict[str, Any]) -> None:
    """Check that the table in a folder was begun with these settings.

    Raises:
        MissingFileError: if none was begun there.
        LlakeyError: if it was begun with others, or their record is broken.
    """
    path = folder / _FILE
    with reading(path, "record of a table"):
        changed = changes(json.loads(path.read_text()), settings)
    if changed:
        raise LlakeyError(
            f"Expected the settings with which the table in {folder} was begun, got a change of "
            f"{', '.join(changed)}; restore them or give another --output_dir."
        )


def changes(begun: Mapping[str, Any], settings: Mapping[str, Any]) -> list[str]:
    """Names of the settings that differ between the beginning and now."""
    found = [name for name, value in settings["plan"].items() if begun["plan"].get(name) != value]
    if list(begun["rows"]) != list(settings["rows"]):
        return [*found, f"rows (they were {', '.join(begun['rows'])})"]
    for name, now in settings["rows"].items():
        before = dict(begun["rows"][name])
        if before["weights"] is None:
            before["weights"] = now["weights"]
        found += [f"{part} of the row {name!r}" for part in now if before.get(part) != now[part]]
    return found
