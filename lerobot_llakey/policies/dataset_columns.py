"""Columns of a training dataset's own files, read before training starts and without an image."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq


def tables_of(dataset_meta: Any, keys: Sequence[str]) -> Iterator[pa.Table]:
    """Some columns of each file of a dataset; nothing of files that lack one or are not on this disk (streamed).

    Args:
        dataset_meta: a ``LeRobotDatasetMetadata``.
        keys: names of columns.
    """
    root = getattr(dataset_meta, "root", None)
    for path in [] if root is None else sorted(Path(root).glob("data/**/*.parquet")):
        if set(keys) <= set(pq.read_schema(path).names):
            yield pq.read_table(path, columns=list(keys))


def texts_of(column: pa.ChunkedArray) -> pa.DictionaryArray:
    """A column of texts, each distinct one held once."""
    if pa.types.is_list(column.type):
        column = pc.list_flatten(column)
    return (
        column.dictionary_encode().combine_chunks()
        if not pa.types.is_dictionary(column.type)
        else column.combine_chunks()
    )
