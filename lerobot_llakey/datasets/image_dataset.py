"""Writing a LeRobotDataset whose pictures are small PNGs inside its parquet files, for fast random access.

LeRobot's own writer stores each picture as a file, reads it back for the statistics and embeds it at last; depth it
stores uncompressed. Here pictures are compressed once, in memory: several times faster, and the files are a quarter of
the size. The result is read by ``LeRobotDataset`` like any other.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image

from lerobot_llakey.datasets.episode_writer import EpisodeWriter, Frame

PNG_LEVEL = 4
"""Of zlib: against level 6, colour takes less than half the time to encode and is a tenth larger."""


def encode_png(image: np.ndarray) -> bytes:
    """PNG of an RGB uint8 (H, W, 3) or depth uint16 (H, W, 1) picture, without loss."""
    buffer = io.BytesIO()
    squeezed = image[..., 0] if image.shape[-1] == 1 else image
    PIL.Image.fromarray(np.ascontiguousarray(squeezed)).save(buffer, "PNG", compress_level=PNG_LEVEL)
    return buffer.getvalue()


class ImageDatasetWriter(EpisodeWriter):
    """Writes episodes to a new dataset of PNGs; use it as a context manager, which finalises it.

    Args:
        repo_id: name of the dataset.
        root: folder, which must not exist yet.
        fps: frames a second.
        features: of the contract, with pictures of dtype ``image``.
        robot_type: noted in the dataset.

    Raises:
        FileExistsError: if the folder exists.
    """

    def __init__(
        self,
        repo_id: str,
        root: Path,
        fps: int,
        features: Mapping[str, Mapping[str, Any]],
        robot_type: str | None = None,
    ) -> None:
        super().__init__(repo_id, root, fps, features, robot_type, use_videos=False)

    def _write_pictures(self, frames: Sequence[Frame]) -> tuple[dict[str, list[Any]], dict[str, Any]]:
        cells = {key: [{"bytes": encode_png(frame[key]), "path": None} for frame in frames] for key in self._pictures}
        return cells, {}
