"""An episode's pictures as small JPEGs, decoded some at a time and kept for a while."""

from __future__ import annotations

import threading
from collections import OrderedDict, defaultdict
from collections.abc import Sequence

import cv2
import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.datasets.video_utils import decode_video_frames

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading

_CHUNK = 32
"""Frames that are decoded together: a video is read forward from a key picture in any case."""
_MOST_BYTES = 256_000_000
_LARGEST = 360
"""Pixels of the shorter side."""
_QUALITY = 85


class Pictures:
    """The colours of a dataset's cameras, frame by frame; may be asked from any thread.

    Args:
        source: the dataset.
        most_bytes: of JPEGs to keep.

    Attributes:
        cameras: their names.
    """

    def __init__(self, source: LeRobotDataset, most_bytes: int = _MOST_BYTES) -> None:
        self.cameras = schema.cameras_of(source.features)
        self._source, self._most_bytes, self._bytes = source, most_bytes, 0
        self._stored = source.hf_dataset.with_format(None)  # pictures as they lie there, before LeRobot's tensors
        self._kept: OrderedDict[tuple[int, str, int], list[bytes]] = OrderedDict()
        self._decoding: defaultdict[str, threading.Lock] = defaultdict(threading.Lock)
        self._keeping = threading.Lock()

    def jpeg(self, episode: int, camera: str, frame: int) -> bytes:
        """A camera's picture.

        Raises:
            LlakeyError: if there is none, or it cannot be read.
        """
        length = int(self._source.meta.episodes[episode]["length"])
        if camera not in self.cameras or not 0 <= frame < length:
            raise LlakeyError(
                f"Expected a camera out of {', '.join(self.cameras) or 'none'} and a frame below {length}, got "
                f"{camera!r} and {frame}; load the page anew."
            )
        key = episode, camera, frame // _CHUNK
        with self._decoding[camera]:  # who asks for the same ones waits for them; decoders serve one thread
            found = self._known(key)
            if found is None:
                begin = key[2] * _CHUNK
                found = [_encode(one) for one in self._read(episode, camera, begin, min(begin + _CHUNK, length))]
                self._keep(key, found)
        return found[frame - key[2] * _CHUNK]

    def _known(self, key: tuple[int, str, int]) -> list[bytes] | None:
        with self._keeping:
            if key in self._kept:
                self._kept.move_to_end(key)
            return self._kept.get(key)

    def _keep(self, key: tuple[int, str, int], found: list[bytes]) -> None:
        with self._keeping:
            self._kept[key] = found
            self._bytes += sum(map(len, found))
            while self._bytes > self._most_bytes and len(self._kept) > 1:
                _, gone = self._kept.popitem(last=False)
                self._bytes -= sum(map(len, gone))

    def _read(self, episode: int, camera: str, begin: int, end: int) -> Sequence[np.ndarray]:
        """Pictures (H, W, 3) of 0..255, RGB."""
        source, key = self._source, schema.image_key(camera)
        row = source.meta.episodes[episode]
        if key not in source.meta.video_keys:
            first = int(row["dataset_from_index"])
            with reading(source.root, "dataset"):
                stored = self._stored.select_columns([key])[first + begin : first + end][key]
                return [np.asarray(picture.convert("RGB")) for picture in stored]
        path = source.root / source.meta.get_video_file_path(episode, key)
        start = row[f"videos/{key}/from_timestamp"]
        times = [start + frame / source.fps for frame in range(begin, end)]
        with reading(path, "video"):
            frames = decode_video_frames(path, times, source.tolerance_s, return_uint8=True)
            return list(frames.permute(0, 2, 3, 1).numpy())


def _encode(picture: np.ndarray) -> bytes:
    height, width = picture.shape[:2]
    scale = min(1.0, _LARGEST / min(height, width))
    if scale < 1:
        size = round(width * scale), round(height * scale)
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    done, data = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    assert done
    return data.tobytes()
