"""Reads the texts of a dataset before training starts: its skill instructions and its basic instructions."""

from __future__ import annotations

from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.dataset_columns import tables_of, texts_of


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
    columns = (table.column(schema.INSTRUCTION) for table in tables_of(dataset_meta, [schema.INSTRUCTION]))
    found = {str(text) for column in columns for text in texts_of(column).dictionary.to_pylist() if text}
    return sorted(found)
