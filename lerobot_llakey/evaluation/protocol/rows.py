"""The rows of a table: which policies are compared, and how each is put together."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import yaml

from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.files import reading

EXPERT = "expert"
"""In place of a checkpoint: the scripted demonstrators."""


@dataclass(frozen=True)
class Row:
    """One policy of a table.

    Attributes:
        name: as printed.
        policy_path: checkpoint folder or Hub name of a policy that acts, or ``expert``.
        command_path, action_path: checkpoints of the two levels. With ``policy_path`` they take the place of its own,
            without it they are put together.
        views: cameras shown to the command policy, where not those that it was trained with.
        overrides: settings of the policy by dotted name, such as ``commander: oracle``. One that is left empty must be
            filled in first; until then the row is skipped.
        paper: name of the paper's row that stands for the same method, for the plot; empty where there is none.
        wording: what the policy is told in place of the skill instruction, as in :class:`Agent`; not set in files.
    """

    name: str
    policy_path: str = ""
    command_path: str = ""
    action_path: str = ""
    views: tuple[str, ...] = ()
    overrides: Mapping[str, Any] = field(default_factory=dict)
    paper: str = ""
    wording: Callable[[str, int], str] | None = None

    @property
    def paths(self) -> list[str]:
        """The checkpoints that it needs."""
        return [path for path in (self.policy_path, self.command_path, self.action_path) if path and path != EXPERT]

    @property
    def slug(self) -> str:
        """The name as a folder's."""
        return "".join(letter if letter.isalnum() else "_" for letter in self.name.lower()).strip("_")

    def described(self) -> dict[str, Any]:
        """All that its results depend on, as it is written down."""
        described = asdict(self)
        # As in the records of tables begun before there was this field.
        return described if self.wording is not None else {k: v for k, v in described.items() if k != "wording"}


def read_rows(rows: str) -> list[Row]:
    """Rows from a YAML file (a list of mappings with the fields of :class:`Row`), or from checkpoints' paths.

    Args:
        rows: a file ending in .yaml or .yml, or what LeRobot calls ``--policy.path``, several separated by commas.

    Raises:
        MissingFileError: if there is no such file.
        LlakeyError: if it does not hold rows, or two have one name.
    """
    if rows.endswith((".yaml", ".yml")):
        path = Path(rows)
        if not path.is_file():
            raise MissingFileError(f"Expected a YAML file with the rows of the table, got {rows}; correct --rows.")
        found = [_row(entry, rows) for entry in _entries(path)]
    else:
        found = [Row(name=_short(path), policy_path=path) for path in map(str.strip, rows.split(",")) if path]
    slugs = [row.slug for row in found]
    if not found or len(set(slugs)) < len(slugs):
        names = [row.name for row in found]
        raise LlakeyError(f"Expected at least one row, each with a name of its own, got {names}; correct --rows.")
    return found


def _entries(path: Path) -> list[Any]:
    with reading(path, "YAML file of rows"):
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    if not isinstance(content, list):
        raise LlakeyError(f"Expected a list of rows in {path}, got {type(content).__name__}; begin each with - name:.")
    return content


def _row(entry: Any, origin: str) -> Row:
    known = [part.name for part in fields(Row) if part.name != "wording"]
    if not isinstance(entry, dict) or not entry.get("name") or set(entry) - set(known):
        raise LlakeyError(f"Expected a row with a name and fields out of {', '.join(known)} in {origin}, got {entry}.")
    for name in ("name", "policy_path", "command_path", "action_path", "paper"):
        if not isinstance(entry.get(name) or "", str):
            raise LlakeyError(f"Expected text as {name} of a row in {origin}, got {entry[name]!r}; correct it.")
    if not isinstance(entry.get("overrides") or {}, dict) or not isinstance(entry.get("views") or [], list):
        raise LlakeyError(
            f"Expected overrides as a mapping and views as a list in the row {entry['name']!r} of {origin}, got "
            f"{entry.get('overrides')!r} and {entry.get('views')!r}; correct them."
        )
    row = Row(**{**entry, "views": tuple(entry.get("views") or ()), "overrides": entry.get("overrides") or {}})
    if not (row.policy_path or row.action_path):
        raise LlakeyError(
            f"Expected a policy_path or an action_path in the row {row.name!r} of {origin}, got neither; add one."
        )
    return row


def _short(path: str) -> str:
    """The telling part of a path such as outputs/action/checkpoints/last/pretrained_model."""
    parts = [part for part in Path(path).parts if part not in ("checkpoints", "last", "pretrained_model")]
    return parts[-1] if parts else path
