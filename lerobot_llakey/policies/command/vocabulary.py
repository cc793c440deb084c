"""Reads the texts of a dataset before training starts: its skill instructions and its basic instructions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError


def dataset_tasks(dataset_meta: Any) -> list[str]:
    """The skill instructions of a dataset, sorted."""
    tasks = getattr(dataset_meta, "tasks", None)
    return [] if tasks is None else sorted(str(task) for task in tasks.index)


def dataset_instructions(dataset_meta: Any) -> list[str]:
    """The distinct basic instructions of a dataset, sorted, read from its parquet files without decoding an image.

    Args:
        dataset_meta: a ``LeRobotDatasetMetadata``.

    Returns:
        The instructions; an empty list where the files are not on this disk (a streamed dataset).

    Raises:
        LlakeyError: if the dataset has no ``instruction`` column.
    """
    if schema.INSTRUCTION not in dataset_meta.features:
        raise LlakeyError(
            f"Expected a dataset with the column {schema.INSTRUCTION!r}, got {dataset_meta.repo_id!r} without it; "
            "make one with `llakey keysteps`."
        )
    found: set[str] = set()
    for path in sorted(Path(dataset_meta.root).glob("data/**/*.parquet")):
        column = pq.read_table(path, columns=[schema.INSTRUCTION]).column(schema.INSTRUCTION)
        if pa.types.is_list(column.type):
            column = pc.list_flatten(column)
        found.update(str(text) for text in pc.unique(column).to_pylist() if text)
    return sorted(found)
