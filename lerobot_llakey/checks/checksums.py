"""Files that are still what they were when the dataset was written.

A bit that flipped in a number, in a picture or in a video often leaves something that can be read and is likely, which
no look at the values can tell. So the datasets that are made here carry the SHA-256 of each of their files.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from pathlib import Path

from tqdm import tqdm

from lerobot_llakey.checks.finding import Finding
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading, write_whole

CHECKSUMS = "meta/llakey_checksums.json"
_HELD = ("data", "meta", "videos")
_SHOWN_BYTES = 4 * 10**9
"""Datasets larger than this get a progress bar."""


def write_checksums(root: Path) -> None:
    """Note the SHA-256 of each file of a dataset that has just been written, or changed on purpose.

    Raises:
        LlakeyError: if the folder cannot be read or written to.
    """
    sums = {str(path.relative_to(root)): _sum(path) for path in _files(root)}
    write_whole(root / CHECKSUMS, json.dumps(sums, indent=1))


def check_checksums(root: Path) -> Iterator[Finding]:
    """Hold the files of a dataset against what was noted; of one without notes nothing is said.

    Data and videos that are gone are told where the dataset is opened, since episodes may be fetched one by one.

    Raises:
        LlakeyError: if a file or the notes cannot be read.
    """
    path = root / CHECKSUMS
    if not path.is_file():
        return
    with reading(path, "list of checksums"):
        noted = {str(name): str(value) for name, value in json.loads(path.read_text(encoding="utf-8")).items()}
    files = _files(root)
    gone = [name for name in sorted(noted) if name.startswith("meta/") and not (root / name).is_file()]
    size = sum(file.stat().st_size for file in files)
    changed, unknown = [], []
    for file in tqdm(files, desc="checksums", unit="file", disable=size < _SHOWN_BYTES):
        name = str(file.relative_to(root))
        if name not in noted:
            unknown.append(name)
        elif noted[name] != _sum(file):
            changed.append(name)
    advice = f"fetch or make it anew; if it was changed on purpose, delete {CHECKSUMS}"
    for names, expected, got in (
        (changed, "the file that was written", "another"),
        (unknown, "no file that was not written with it", "one"),
        (gone, "the file that was written", "none"),
    ):
        if names:
            more = f" (and {len(names) - 1} more files)" if len(names) > 1 else ""
            yield Finding(names[0], f"{expected} (by {CHECKSUMS})", f"{got}{more}", advice)


def refuse_changed_files(root: Path) -> None:
    """Refuse to make another dataset of one whose files are not what was written.

    Raises:
        LlakeyError: naming the first such file.
    """
    for finding in check_checksums(root):
        raise LlakeyError(finding.sentence(str(root)))


def _files(root: Path) -> list[Path]:
    folders = [root / name for name in _HELD]
    found = [path for folder in folders for path in folder.rglob("*") if path.is_file()]
    return sorted(path for path in found if not path.name.startswith((".", "llakey_")))


def _sum(path: Path) -> str:
    with reading(path), path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
