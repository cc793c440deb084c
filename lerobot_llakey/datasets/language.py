"""LeRobot's own ``language_persistent`` column, made from a demonstrations dataset's instruction column.

Each episode's instructions become rows of style ``subtask`` stamped at the start of their segments, so that LeRobot's
recipes, ``active_at(t, style=subtask)`` and viewers find them.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from lerobot.datasets.io_utils import write_table_one_row_group_per_episode
from lerobot.datasets.language import LANGUAGE_PERSISTENT, language_feature_info
from lerobot.datasets.utils import INFO_PATH

from lerobot_llakey import schema

_ROWS = pa.list_(
    pa.struct(
        [
            ("role", pa.string()),
            ("content", pa.string()),
            ("style", pa.string()),
            ("timestamp", pa.float32()),
            ("camera", pa.string()),
            ("tool_calls", pa.list_(pa.string())),
        ]
    )
)
"""LeRobot's row, with tool calls as text: pyarrow cannot build arrays of its JSON type, and there are none here."""


def write_language(root: Path) -> None:
    """Add the column to a dataset's files, or make it anew.

    Args:
        root: folder of a finished demonstrations dataset.

    Raises:
        ValueError: if the dataset has no instruction column.
    """
    for path in sorted((root / "data").rglob("*.parquet")):
        table = pq.read_table(path)
        if schema.INSTRUCTION not in table.column_names:
            raise ValueError(
                f"Expected the column {schema.INSTRUCTION} in {path}, found none; annotate the dataset first."
            )
        episodes: dict[int, list[dict[str, Any]]] = {}
        indices = table["episode_index"].to_pylist()
        segments = table[schema.KEYFRAME_INDEX].to_pylist()
        times = table["timestamp"].to_pylist()
        begun: set[tuple[int, int]] = set()
        for episode, segment, time, text in zip(
            indices, segments, times, table[schema.INSTRUCTION].to_pylist(), strict=True
        ):
            if (episode, segment) not in begun:
                begun.add((episode, segment))
                episodes.setdefault(episode, []).append(_row(text, time))
        column = pa.array([episodes[episode] for episode in indices], type=_ROWS)
        if LANGUAGE_PERSISTENT in table.column_names:
            table = table.drop_columns([LANGUAGE_PERSISTENT])
        # The types that the datasets library noted beside the data no longer name all columns.
        table = _without_extensions(table.append_column(LANGUAGE_PERSISTENT, column)).replace_schema_metadata(None)
        fresh = path.with_suffix(".tmp")
        write_table_one_row_group_per_episode(table, fresh)
        fresh.replace(path)
    info_path = root / INFO_PATH
    info = json.loads(info_path.read_text())
    info["features"][LANGUAGE_PERSISTENT] = language_feature_info()[LANGUAGE_PERSISTENT]
    fresh = info_path.with_suffix(".tmp")
    fresh.write_text(json.dumps(info, indent=4))
    fresh.replace(info_path)


def _without_extensions(table: pa.Table) -> pa.Table:
    """The table with matrices as plain nested lists: LeRobot 0.6.1 cannot merge videos datasets that have others."""
    for index, field in enumerate(table.schema):
        if isinstance(field.type, pa.ExtensionType):
            storage = pa.chunked_array([chunk.storage for chunk in table.column(index).chunks], field.type.storage_type)
            table = table.set_column(index, field.name, storage)
    return table


def _row(instruction: str, timestamp: float) -> dict[str, Any]:
    return {
        "role": "assistant",
        "content": instruction,
        "style": "subtask",
        "timestamp": timestamp,
        "camera": None,
        "tool_calls": None,
    }
