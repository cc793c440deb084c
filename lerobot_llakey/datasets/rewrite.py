"""Changing columns of a finished LeRobotDataset in place, without touching its pictures and videos."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from lerobot.datasets.io_utils import load_stats, write_stats, write_table_one_row_group_per_episode
from lerobot.datasets.utils import EPISODES_DIR, INFO_PATH

from lerobot_llakey.files import replacing, write_whole


def rewrite(
    root: Path, columns: Callable[[pa.Table], Mapping[str, pa.Array]], features: Mapping[str, Mapping[str, Any]]
) -> None:
    """Set columns of a dataset; its statistics of them, if any, are left to the caller.

    Args:
        root: folder of a finished dataset. Each file is replaced in one step.
        columns: given the rows of a file, the columns to add or to replace.
        features: LeRobot's description of these columns.
    """
    for path in sorted((root / "data").rglob("*.parquet")):
        table = pq.read_table(path)
        for key, column in columns(table).items():
            if key in table.column_names:
                table = table.drop_columns([key])
            table = table.append_column(key, column)
        with replacing(path) as fresh:
            write_table_one_row_group_per_episode(_plain(table), fresh)
    _forget_episode_stats(root, features)
    path = root / INFO_PATH
    info = json.loads(path.read_text())
    info["features"].update(json.loads(json.dumps(features)))
    write_whole(path, json.dumps(info, indent=4))


def drop(root: Path, keys: Collection[str]) -> None:
    """Remove columns from a finished dataset, with their statistics, where it has them."""
    path = root / INFO_PATH
    info = json.loads(path.read_text())
    if not set(keys) & set(info["features"]):
        return
    for file in sorted((root / "data").rglob("*.parquet")):
        table = pq.read_table(file)
        with replacing(file) as fresh:
            write_table_one_row_group_per_episode(_plain(table.drop_columns(_among(keys, table))), fresh)
    _forget_episode_stats(root, keys)
    write_stats({key: values for key, values in (load_stats(root) or {}).items() if key not in keys}, root)
    info["features"] = {key: feature for key, feature in info["features"].items() if key not in keys}
    write_whole(path, json.dumps(info, indent=4))


def _forget_episode_stats(root: Path, keys: Collection[str]) -> None:
    """Remove what the episodes' files say about columns that changed or are gone."""
    stale = tuple(f"stats/{key}/" for key in keys)
    for path in sorted((root / EPISODES_DIR).rglob("*.parquet")):
        table = pq.read_table(path)
        kept = [name for name in table.column_names if not name.startswith(stale)]
        if len(kept) < table.num_columns:
            with replacing(path) as fresh:
                pq.write_table(table.select(kept), fresh)


def _among(keys: Collection[str], table: pa.Table) -> list[str]:
    return [key for key in keys if key in table.column_names]


def _plain(table: pa.Table) -> pa.Table:
    """The table with matrices as nested lists and without the types that the datasets library notes beside the data.

    LeRobot 0.6.1 cannot merge datasets of videos whose matrices are of that library's own types; it reads both alike.
    """
    for index, field in enumerate(table.schema):
        if isinstance(field.type, pa.ExtensionType):
            storage = pa.chunked_array([chunk.storage for chunk in table.column(index).chunks], field.type.storage_type)
            table = table.set_column(index, field.name, storage)
    return table.replace_schema_metadata(None)
