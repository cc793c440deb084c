"""Changing columns of a finished LeRobotDataset in place, without touching its pictures and videos."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from lerobot.datasets.compute_stats import aggregate_stats, compute_episode_stats
from lerobot.datasets.io_utils import load_stats, write_stats, write_table_one_row_group_per_episode
from lerobot.datasets.utils import DEFAULT_VIDEO_PATH, EPISODES_DIR, INFO_PATH

from lerobot_llakey.checks.checksums import refuse_changed_files, write_checksums
from lerobot_llakey.files import replacing, write_whole

_TEXTS = ("string", "language")
Columns = Mapping[str, pa.Array]
EpisodeStats = dict[str, dict[str, np.ndarray]]


@dataclass(frozen=True)
class AddedVideo:
    """Videos that were written for a new feature.

    Attributes:
        feature: LeRobot's description of it.
        places: by episode, where its video lies: chunk and file index, first and last second.
        stats: by episode.
    """

    feature: Mapping[str, Any]
    places: Sequence[Mapping[str, float]]
    stats: Sequence[Mapping[str, np.ndarray]]


def rewrite(
    root: Path,
    columns: Callable[[pa.Table], Columns],
    features: Mapping[str, Mapping[str, Any]],
    dropped: Collection[str] = (),
    videos: Mapping[str, AddedVideo] | None = None,
) -> None:
    """Set and remove columns of a dataset, with their statistics, and note videos that were added.

    Args:
        root: folder of a finished dataset. Each file is replaced in one step.
        columns: given the rows of a file, the columns to add or to replace.
        features: LeRobot's description of these columns.
        dropped: columns to remove, where there are any.
        videos: that lie in the dataset's folder already, by feature name.

    Raises:
        LlakeyError: if files are not those that the dataset was written with.
    """
    refuse_changed_files(root)
    videos = videos or {}
    numbers = [key for key, feature in features.items() if feature["dtype"] not in _TEXTS]
    stats: dict[int, EpisodeStats] = {}
    for path in sorted((root / "data").rglob("*.parquet")):
        table = plain(pq.read_table(path))
        for key, column in columns(table).items():
            if key in table.column_names:
                table = table.drop_columns([key])
            table = table.append_column(key, column)
        table = table.drop_columns([key for key in dropped if key in table.column_names])
        with replacing(path) as fresh:
            write_table_one_row_group_per_episode(table, fresh)
        episodes = table["episode_index"].to_numpy()
        values = {key: np.array(table[key].to_pylist(), dtype=features[key]["dtype"]) for key in numbers}
        for episode in np.unique(episodes):
            rows = {key: column[episodes == episode] for key, column in values.items()}
            stats[int(episode)] = compute_episode_stats(rows, features)
            stats[int(episode)] |= {key: dict(video.stats[episode]) for key, video in videos.items()}
    _restate(root, stats, {*features, *dropped}, videos)
    path = root / INFO_PATH
    info = json.loads(path.read_text())
    info["features"] = {key: feature for key, feature in info["features"].items() if key not in dropped}
    info["features"].update(json.loads(json.dumps({**features, **{key: one.feature for key, one in videos.items()}})))
    if videos:
        info["video_path"] = info.get("video_path") or DEFAULT_VIDEO_PATH
    write_whole(path, json.dumps(info, indent=4))
    write_checksums(root)


def drop(root: Path, keys: Collection[str]) -> None:
    """Remove columns from a finished dataset, with their statistics, where it has them."""
    rewrite(root, lambda _: {}, {}, keys)


def as_column(values: np.ndarray) -> pa.Array:
    """A column of numbers (N,) or vectors (N, D)."""
    if values.ndim == 2:
        return pa.FixedSizeListArray.from_arrays(pa.array(values.reshape(-1)), values.shape[1])
    return pa.array(values)


def plain(table: pa.Table) -> pa.Table:
    """The table with matrices as nested lists and without the types that the datasets library notes beside the data."""
    for index, field in enumerate(table.schema):
        if isinstance(field.type, pa.ExtensionType):
            storage = pa.chunked_array([chunk.storage for chunk in table.column(index).chunks], field.type.storage_type)
            table = table.set_column(index, field.name, storage)
    return table.replace_schema_metadata(None)


def _restate(
    root: Path, stats: Mapping[int, EpisodeStats], stale: Collection[str], videos: Mapping[str, AddedVideo]
) -> None:
    """Replace what the dataset says of columns that changed, came or are gone, as a whole and by episode."""
    for path in sorted((root / EPISODES_DIR).rglob("*.parquet")):
        table = pq.read_table(path)
        table = table.select([name for name in table.column_names if not name.startswith(_prefixes(stale))])
        episodes = table["episode_index"].to_pylist()
        rows = [stats[episode] for episode in episodes]
        for key, known in rows[0].items() if rows else ():
            for name in known:
                values = pa.array([row[key][name].tolist() for row in rows])
                table = table.append_column(f"stats/{key}/{name}", values)
        for key, video in videos.items():
            for name in video.places[0]:
                values = pa.array([video.places[episode][name] for episode in episodes])
                table = table.append_column(f"videos/{key}/{name}", values)
        with replacing(path) as fresh:
            pq.write_table(table, fresh)
    kept = {key: values for key, values in (load_stats(root) or {}).items() if key not in stale}
    write_stats(kept | aggregate_stats(list(stats.values())), root)


def _prefixes(keys: Collection[str]) -> tuple[str, ...]:
    return tuple(f"stats/{key}/" for key in keys)
