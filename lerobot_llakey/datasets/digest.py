"""One number for all that a dataset holds, however it is cut into files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import av
import pyarrow as pa
import pyarrow.parquet as pq

from lerobot_llakey.datasets.opening import open_metadata
from lerobot_llakey.files import reading


def digest(root: Path) -> str:
    """A SHA-256 over a dataset's rows, pictures, videos' frames, tasks and number of episodes, all in order.

    Two datasets that differ only in how rows and videos are distributed over files have the same.

    Args:
        root: folder of a LeRobotDataset.

    Raises:
        LlakeyError: if it cannot be read.
    """
    meta = open_metadata(root)
    columns: dict[str, Any] = {}
    for path in sorted((root / "data").rglob("*.parquet")):
        with reading(path, "parquet file"):
            table = pq.read_table(path)
        for name in table.column_names:
            for chunk in table[name].chunks:
                _add(columns, name, chunk)
    for key in meta.video_keys:
        columns[key] = hashlib.sha256()
        for path in sorted((root / "videos" / key).rglob("*.mp4")):
            with reading(path, "video"):
                for frame in _frames(path):
                    columns[key].update(frame)
    tasks = [str(task) for task in meta.tasks.sort_values("task_index").index]
    whole = [meta.total_episodes, tasks, sorted((name, found.hexdigest()) for name, found in columns.items())]
    return hashlib.sha256(json.dumps(whole).encode()).hexdigest()


def _add(columns: dict[str, Any], name: str, values: pa.Array) -> None:
    """Add values to a column's sum; what they are made of, fields or elements, is summed each by itself."""
    if pa.types.is_struct(values.type):
        for field, within in zip(values.type, values.flatten(), strict=True):
            _add(columns, f"{name}/{field.name}", within)
    elif (
        pa.types.is_list(values.type) or pa.types.is_large_list(values.type) or pa.types.is_fixed_size_list(values.type)
    ):
        _add(columns, f"{name}/length", values.value_lengths())
        _add(columns, f"{name}/element", values.flatten())
    else:
        found = columns.setdefault(name, hashlib.sha256(str(values.type).encode()))
        if pa.types.is_primitive(values.type) and not values.null_count:
            found.update(values.to_numpy(zero_copy_only=False).tobytes())
        else:
            for value in values.to_pylist():
                content = value if isinstance(value, bytes) else json.dumps(value).encode()
                found.update(len(content).to_bytes(8, "big") + content)


def _frames(path: Path) -> Iterator[bytes]:
    """The decoded frames of a video: joining videos may add headers to the coded ones."""
    with av.open(str(path)) as container:
        for frame in container.decode(video=0):
            yield frame.to_ndarray().tobytes()
