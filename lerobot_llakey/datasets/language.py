"""LeRobot's own ``language_persistent`` column, made from a demonstrations dataset's instruction column.

Each episode's instructions become rows of style ``subtask`` stamped at the start of their segments, so that LeRobot's
recipes, ``active_at(t, style=subtask)`` and viewers find them.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
from lerobot.datasets.language import LANGUAGE_PERSISTENT, language_feature_info

from lerobot_llakey import schema
from lerobot_llakey.datasets.rewrite import rewrite
from lerobot_llakey.errors import LlakeyError

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
        LlakeyError: if the dataset has no instruction column.
    """
    rewrite(root, _column, {LANGUAGE_PERSISTENT: language_feature_info()[LANGUAGE_PERSISTENT]})


def _column(table: pa.Table) -> Mapping[str, pa.Array]:
    if schema.INSTRUCTION not in table.column_names:
        raise LlakeyError(
            f"Expected the column {schema.INSTRUCTION}, got only {', '.join(table.column_names)}; annotate the dataset "
            "first."
        )
    columns = ("episode_index", schema.KEYFRAME_INDEX, "timestamp", schema.INSTRUCTION)
    episodes: dict[int, list[dict[str, Any]]] = {}
    begun: set[tuple[int, int]] = set()
    for episode, segment, time, text in zip(*(table[name].to_pylist() for name in columns), strict=True):
        if (episode, segment) not in begun:
            begun.add((episode, segment))
            episodes.setdefault(episode, []).append(_row(text, time))
    return {LANGUAGE_PERSISTENT: pa.array([episodes[i] for i in table["episode_index"].to_pylist()], type=_ROWS)}


def _row(instruction: str, timestamp: float) -> dict[str, Any]:
    return {
        "role": "assistant",
        "content": instruction,
        "style": "subtask",
        "timestamp": timestamp,
        "camera": None,
        "tool_calls": None,
    }
