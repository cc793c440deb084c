"""The columns of a dataset as arrays, file by file and without its pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from lerobot_llakey import schema
from lerobot_llakey.checks.finding import Place
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading
from lerobot_llakey.hand import hand_columns, joint_columns, names_of, read_hand

EPISODE, FRAME, INDEX, TIME, TASKS = "episode_index", "frame_index", "index", "timestamp", "task_index"
"""LeRobot's own columns."""
_NOT_READ = ("image", "video", "language")
MOST_ROWS = 1_000_000
"""Rows looked at in a dataset; of a larger one, files at equal distances."""


@dataclass(frozen=True)
class Columns:
    """The rows of one file.

    Attributes:
        values: name -> (N, ...) numbers, or (N,) texts with None where there is none.
        odd: name -> what was found in place of values of the shape that ``info.json`` gives.
        hand: (N, 8) pose and opening of the state, None where its names do not tell.
        joints: (N, J) what of the state is named as a joint.
    """

    values: Mapping[str, np.ndarray]
    odd: Mapping[str, str]
    hand: np.ndarray | None = None
    joints: np.ndarray | None = None

    def __contains__(self, key: str) -> bool:
        return key in self.values

    def __getitem__(self, key: str) -> np.ndarray:
        return self.values[key]

    def __len__(self) -> int:
        return max(map(len, self.values.values()), default=0)

    def has(self, *keys: str) -> bool:
        """Whether all these columns are there."""
        return all(key in self.values for key in keys)

    def is_finite(self, *keys: str) -> bool:
        """Whether all numbers of these columns are finite, of those that are there."""
        return all(bool(np.isfinite(self.values[key]).all()) for key in keys if key in self.values)

    def place(self, wrong: np.ndarray) -> Place:
        """The first of the rows that a mask (N,) marks, and how many more there are."""
        rows = np.flatnonzero(wrong)
        row, more = int(rows[0]), len(rows) - 1
        numbers = [int(self[key][row]) if key in self else None for key in (EPISODE, FRAME)]
        named = [f"{word} {number}" for word, number in zip(("episode", "frame"), numbers, strict=True)
                 if number is not None]  # fmt: skip
        words = ", ".join(named or [f"row {row}"]) + (f" (and {more} more rows)" if more else "")
        return Place(words, *numbers)

    def episodes(self) -> list[slice]:
        """The rows of each episode, in their order; all rows where no column tells."""
        if EPISODE not in self:
            return [slice(0, len(self))]
        starts = [0, *(np.flatnonzero(np.diff(self[EPISODE])) + 1).tolist(), len(self)]
        return [slice(start, stop) for start, stop in pairwise(starts) if stop > start]


def read_columns(root: Path, features: Mapping[str, Mapping[str, Any]], most: int = MOST_ROWS) -> Iterator[Columns]:
    """Read a dataset's columns, one file after the other.

    Args:
        root: folder of the dataset.
        features: as its ``info.json`` describes them; pictures and language are left out.
        most: rows to look at, at about equal distances where there are more.

    Raises:
        LlakeyError: if a file cannot be read.
    """
    wanted = [key for key, feature in features.items() if feature.get("dtype") not in _NOT_READ]
    paths = sorted((root / "data").rglob("*.parquet"))
    rows = [_rows(path) for path in paths]
    keep = max(1, int(len(paths) * min(1.0, most / max(sum(rows), 1))))
    for place in np.unique(np.linspace(0, len(paths) - 1, keep).astype(int)) if paths else ():
        path = paths[place]
        with reading(path, "parquet file"), pq.ParquetFile(path) as file:
            table = file.read(columns=[key for key in wanted if key in file.schema_arrow.names])
        yield _columns(table, features)


def _rows(path: Path) -> int:
    with reading(path, "parquet file"):
        return int(pq.read_metadata(path).num_rows)


def _columns(table: pa.Table, features: Mapping[str, Mapping[str, Any]]) -> Columns:
    values: dict[str, np.ndarray] = {}
    odd: dict[str, str] = {}
    for key in table.column_names:
        array = table[key].combine_chunks()
        if features[key].get("dtype") == "string":
            if _is_text(array.type):
                values[key] = np.array([None, *array.to_pylist()], dtype=object)[1:]
            else:
                odd[key] = f"{array.type}"
            continue
        try:
            values[key] = _numbers(array, tuple(features[key].get("shape") or (1,)))
        except (ValueError, TypeError, pa.ArrowException):
            odd[key] = f"{array.type} of {len(array)} rows"
    return Columns(values, odd, *_of_state(values.get(schema.STATE), features))


def _of_state(state: np.ndarray | None, features: Mapping[str, Mapping[str, Any]]) -> tuple[np.ndarray | None, ...]:
    """Hands (N, 8) and joints (N, J) of states; None where their names do not tell."""
    if state is None or state.ndim != 2:
        return None, None
    names = names_of(features[schema.STATE])
    try:
        hand = read_hand(state, hand_columns(names))
    except LlakeyError:
        return None, None
    return hand, state[:, joint_columns(names)]


def _is_text(kind: pa.DataType) -> bool:
    return pa.types.is_string(kind) or pa.types.is_large_string(kind)


def _numbers(array: pa.Array, shape: Sequence[int]) -> np.ndarray:
    """A column of numbers or of nested lists of numbers as (N, *shape), without the last axis where it is (1,)."""
    count = len(array)
    if isinstance(array, pa.ExtensionArray):
        array = array.storage
    while pa.types.is_nested(array.type):
        if array.null_count:
            raise ValueError("a row is missing")
        array = array.flatten()
    flat = array.to_numpy(zero_copy_only=False)
    if flat.dtype == object:
        raise ValueError("not numbers")
    return flat.reshape(count) if tuple(shape) == (1,) else flat.reshape(count, *shape)
