"""What a collected dataset says about its making, in a file of its own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading

RECORD = "meta/llakey_collect.json"
"""The file: settings, number of episodes, and how many were discarded by reason."""


def read_record(root: Path) -> dict[str, Any]:
    """What a collected dataset says about its making.

    Raises:
        LlakeyError: if the folder is not one, or what it says cannot be read.
    """
    path = root / RECORD
    if not path.exists():
        raise LlakeyError(f"Expected {root} to be absent or collected by llakey, got another folder; choose a new one.")
    with reading(path, "record of a collection"):
        record: dict[str, Any] = json.loads(path.read_text())
        _ = record["settings"], int(record["episodes"]), dict(record["discarded"])
    return record
