"""Writing the rows, statistics and notes of a LeRobotDataset, episode by episode; its pictures are written elsewhere.

LeRobot's own writer takes a fingerprint of each episode's table, embeds pictures where there are none, and looks at
every pixel for the statistics: together, most of what collecting took. The result is read by ``LeRobotDataset`` like
any other.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from datasets.arrow_writer import TypedSequence
from lerobot.datasets.compute_stats import compute_episode_stats, get_feature_stats
from lerobot.datasets.dataset_metadata import LeRobotDatasetMetadata
from lerobot.datasets.feature_utils import get_hf_features_from_features, validate_frame

from lerobot_llakey import schema
from lerobot_llakey.checks.checksums import write_checksums
from lerobot_llakey.errors import LlakeyError

Frame = Mapping[str, Any]
Statistics = dict[str, np.ndarray]
_STATISTICS_STRIDE = 8
"""Statistics look at every eighth pixel in both directions of an episode's pictures."""
_FILE_MEGABYTES = 100


class EpisodeWriter(ABC):
    """Writes episodes to a new dataset; use it as a context manager, which finalises it.

    Args:
        repo_id: name of the dataset.
        root: folder, which must not exist yet.
        fps: frames a second.
        features: of the contract, with pictures of dtype ``image`` or ``video``.
        robot_type: noted in the dataset.
        use_videos: whether pictures are videos.

    Raises:
        FileExistsError: if the folder exists.
    """

    def __init__(
        self,
        repo_id: str,
        root: Path,
        fps: int,
        features: Mapping[str, Mapping[str, Any]],
        robot_type: str | None,
        use_videos: bool,
    ) -> None:
        noted = {key: dict(feature) for key, feature in features.items()}
        for feature in noted.values():
            if (feature.get("info") or {}).get("is_depth_map"):
                feature["info"] = {**feature["info"], "depth_unit": "mm"}
        self.meta = LeRobotDatasetMetadata.create(
            repo_id, fps, noted, robot_type=robot_type, root=root, use_videos=use_videos
        )
        self._hf_features = get_hf_features_from_features(self.meta.features)
        self._schema: pa.Schema = self._hf_features.arrow_schema
        self._pictures = list(self.meta.camera_keys)
        self._file = 0
        self._parquet: pq.ParquetWriter | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.finalize()

    def add_episode(self, frames: Iterable[Frame]) -> None:
        """Write one episode.

        Args:
            frames: as ``LeRobotDataset.add_frame`` takes them, ``task`` included; depth uint16 (H, W, 1) millimetres.

        Raises:
            ValueError: if there are no frames or one does not fit the features.
        """
        frames = list(frames)
        if not frames:
            raise LlakeyError("Expected an episode of one frame or more, got none; leave it out.")
        for frame in frames:
            validate_frame(dict(frame), self.meta.features)
        count, episode, first = len(frames), self.meta.total_episodes, self.meta.total_frames
        tasks = [str(frame[schema.TASK]) for frame in frames]
        self.meta.save_episode_tasks(list(dict.fromkeys(tasks)))
        columns: dict[str, np.ndarray] = {
            "timestamp": np.arange(count, dtype=np.float32) / self.meta.fps,
            "frame_index": np.arange(count),
            "episode_index": np.full(count, episode),
            "index": np.arange(first, first + count),
            "task_index": np.array([self.meta.get_task_index(task) for task in tasks]),
        }
        for key, feature in self.meta.features.items():
            if key in columns or key in self._pictures:
                continue
            stacked = np.stack([np.asarray(frame[key]) for frame in frames])
            columns[key] = stacked.reshape(count) if tuple(feature["shape"]) == (1,) else stacked
        stats = compute_episode_stats(columns, self.meta.features)
        stats |= {key: self._picture_statistics(key, frames) for key in self._pictures}
        cells, place = self._write_pictures(frames)
        self._write_rows({**columns, **cells})
        place |= {
            "data/chunk_index": 0,
            "data/file_index": self._file,
            "dataset_from_index": first,
            "dataset_to_index": first + count,
        }
        self.meta.save_episode(episode, count, list(dict.fromkeys(tasks)), stats, place)

    @abstractmethod
    def _write_pictures(self, frames: Sequence[Frame]) -> tuple[dict[str, list[Any]], dict[str, Any]]:
        """Write an episode's pictures: the cells of their columns, where they have any, and where they were put."""

    def _picture_statistics(self, key: str, frames: Sequence[Frame]) -> Statistics:
        """Statistics (C, 1, 1) of pictures: RGB in 0..1, depth in millimetres, as LeRobot has them."""
        step = _STATISTICS_STRIDE
        pixels = np.stack([frame[key][step // 2 :: step, step // 2 :: step] for frame in frames]).transpose(0, 3, 1, 2)
        stats = get_feature_stats(pixels, axis=(0, 2, 3), keepdims=True)
        scale = 1.0 if key in self.meta.depth_keys else 255.0
        return {name: value if name == "count" else np.squeeze(value / scale, axis=0) for name, value in stats.items()}

    def _write_rows(self, cells: Mapping[str, Any]) -> None:
        """Append one episode as one row group."""
        columns = [pa.array(TypedSequence(cells[key], type=kind)) for key, kind in self._hf_features.items()]
        table = pa.Table.from_arrays(columns, schema=self._schema)
        path = self._path()
        if self._parquet is not None and path.stat().st_size > _FILE_MEGABYTES * 2**20:
            self._parquet.close()
            self._parquet, self._file = None, self._file + 1
            path = self._path()
        if self._parquet is None:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._parquet = pq.ParquetWriter(path, schema=table.schema, compression="snappy", use_dictionary=True)
        self._parquet.write_table(table)

    def _path(self) -> Path:
        return self.meta.root / self.meta.data_path.format(chunk_index=0, file_index=self._file)

    def finalize(self) -> None:
        """Close all files; without it the dataset cannot be read."""
        if self._parquet is not None:
            self._parquet.close()
            self._parquet = None
        self.meta.finalize()
        write_checksums(self.meta.root)
