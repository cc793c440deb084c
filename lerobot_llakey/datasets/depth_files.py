"""Depth that was recorded beside a dataset: one 16-bit PNG in millimetres for each frame, as videos of its copy.

The layout is ``FOLDER/CAMERA/episode_000/frame_000000.png``, cameras named as in the dataset.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np
from lerobot.datasets.compute_stats import get_feature_stats
from lerobot.datasets.dataset_metadata import LeRobotDatasetMetadata
from lerobot.datasets.depth_utils import quantize_depth
from lerobot.datasets.utils import DEFAULT_VIDEO_PATH
from lerobot.datasets.video_utils import get_video_info
from PIL import Image
from tqdm import tqdm

from lerobot_llakey import schema
from lerobot_llakey.datasets.demonstrations import depth_encoder
from lerobot_llakey.datasets.rewrite import AddedVideo
from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.files import reading

_SIXTEEN_BITS = ("I;16", "I;16B", "I;16L", "I")
"""What Pillow calls grey pictures of 16 bits."""
_STRIDE = 8
"""Statistics look at every eighth pixel in both directions."""


@dataclass(frozen=True)
class DepthFiles:
    """Depth pictures that fit a dataset.

    Attributes:
        folders: by camera and episode, in order.
        sizes: height and width by camera.
    """

    folders: Mapping[str, tuple[Path, ...]]
    sizes: Mapping[str, schema.Size]

    def write(self, root: Path, meta: LeRobotDatasetMetadata) -> dict[str, AddedVideo]:
        """Write one lossless video for each camera and episode into a copy of the dataset.

        Depth beyond the contract's range counts as its end, as in every dataset here.

        Args:
            root: folder of the copy.
            meta: of the dataset.

        Returns:
            What :func:`lerobot_llakey.datasets.rewrite.rewrite` notes of them, by feature name.

        Raises:
            LlakeyError: if a picture is broken, has another size, or is not of 16 bits.
        """
        written = {}
        count = sum(map(len, self.folders.values()))
        with tqdm(total=count, desc="depth", unit="episode") as bar:
            for camera, folders in self.folders.items():
                key, places, stats = schema.depth_key(camera), [], []
                for episode, folder in enumerate(folders):
                    chunk, file = divmod(episode, meta.chunks_size)
                    path = root / DEFAULT_VIDEO_PATH.format(video_key=key, chunk_index=chunk, file_index=file)
                    pictures = list(_encode(_pictures(folder, self.sizes[camera]), path, meta.fps, self.sizes[camera]))
                    ends = {"from_timestamp": 0.0, "to_timestamp": len(pictures) / meta.fps}
                    places.append({"chunk_index": chunk, "file_index": file, **ends})
                    found = get_feature_stats(np.stack(pictures)[:, None], axis=(0, 2, 3), keepdims=True)
                    squeezed = {name: np.squeeze(of, axis=0) for name, of in found.items() if name != "count"}
                    stats.append({**squeezed, "count": found["count"]})
                    bar.update()
                first = root / DEFAULT_VIDEO_PATH.format(video_key=key, chunk_index=0, file_index=0)
                info = {**get_video_info(first, video_encoder=depth_encoder(self.sizes[camera])), "depth_unit": "mm"}
                shape, axes = (*self.sizes[camera], 1), ["height", "width", "channels"]
                feature = {"dtype": "video", "shape": shape, "names": axes, "info": info}
                written[key] = AddedVideo(feature, places, stats)
        return written


def find_depth(folder: Path, meta: LeRobotDatasetMetadata) -> DepthFiles:
    """Find the depth pictures of a dataset's cameras, and hold their number and size against it.

    Args:
        folder: one folder a camera.
        meta: of the dataset.

    Raises:
        MissingFileError: if there is no such folder.
        LlakeyError: naming the camera, folder or picture that is missing or does not fit.
    """
    if not folder.is_dir():
        raise MissingFileError(f"Expected a folder of depth pictures at {folder}, found none; check --depth.")
    cameras, sizes = sorted(path.name for path in folder.iterdir() if path.is_dir()), {}
    known = schema.cameras_of(meta.features)
    _check_cameras(cameras, known, meta.features, folder)
    folders: dict[str, tuple[Path, ...]] = {}
    for camera in cameras:
        height, width = tuple(meta.features[schema.image_key(camera)]["shape"])[:2]
        if height % 2 or width % 2:
            raise LlakeyError(
                f"Expected a camera of even height and width for depth videos, got {width}x{height} pixels of "
                f"{camera}; leave it away, or record it in an even size."
            )
        sizes[camera] = int(height), int(width)
        folders[camera] = tuple(folder / camera / f"episode_{at:03d}" for at in range(meta.total_episodes))
        for episode, place in enumerate(folders[camera]):
            length = int(meta.episodes[episode]["length"])
            wanted = [f"frame_{frame:06d}.png" for frame in range(length)]
            there = sorted(path.name for path in place.iterdir()) if place.is_dir() else []
            if there != wanted:
                odd = min({*wanted} ^ {*there})
                raise LlakeyError(
                    f"Expected {length} depth pictures, {wanted[0]} to {wanted[-1]}, in {place}, got {len(there)} "
                    f"files ({odd} is {'missing' if odd in wanted else 'not one of them'}); write one for each frame."
                )
            for name in wanted:
                _check_picture(place / name, sizes[camera])
    return DepthFiles(folders, sizes)


def _check_cameras(cameras: list[str], known: Collection[str], features: Collection[str], folder: Path) -> None:
    if unknown := sorted(set(cameras) - set(known)):
        raise LlakeyError(
            f"Expected folders named as the recording's cameras ({', '.join(known) or 'it has none'}) in {folder}, got "
            f"{', '.join(unknown)}; rename them."
        )
    if not cameras:
        raise LlakeyError(
            f"Expected one folder a camera ({', '.join(known)}) in {folder}, got none; write depth as "
            "CAMERA/episode_000/frame_000000.png."
        )
    if twice := [camera for camera in cameras if schema.depth_key(camera) in features]:
        raise LlakeyError(
            f"Expected depth files of cameras without depth, got {', '.join(twice)}, whose depth the recording holds; "
            "leave their folders away."
        )


def _check_picture(path: Path, size: schema.Size) -> None:
    with reading(path, "PNG of depth"), Image.open(path) as picture:
        mode, (width, height) = picture.mode, picture.size
    if mode not in _SIXTEEN_BITS or (height, width) != size:
        raise LlakeyError(
            f"Expected depth in grey of 16 bits and {size[1]}x{size[0]} pixels, aligned with the colours, in {path}, "
            f"got {width}x{height} pixels of {mode}; write millimetres so."
        )


def _pictures(folder: Path, size: schema.Size) -> Iterator[np.ndarray]:
    for path in sorted(folder.iterdir()):
        with reading(path, "PNG of depth"), Image.open(path) as picture:
            yield np.asarray(picture).astype(np.uint16).reshape(size)


def _encode(pictures: Iterator[np.ndarray], path: Path, fps: int, size: tuple[int, int]) -> Iterator[np.ndarray]:
    """Write pictures as a video as LeRobot does, and give what statistics look at, a part of each."""
    encoder = depth_encoder(size)
    scale = {"shift": encoder.shift, "use_log": encoder.use_log, "pix_fmt": encoder.pix_fmt}
    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w") as output:
        stream = output.add_stream(encoder.vcodec, fps, options=encoder.get_codec_options(1, as_strings=True))
        stream.pix_fmt = encoder.pix_fmt
        for picture in pictures:
            stream.height, stream.width = picture.shape
            frame = quantize_depth(picture, encoder.depth_min, encoder.depth_max, **scale)
            output.mux(stream.encode(frame))
            yield picture[_STRIDE // 2 :: _STRIDE, _STRIDE // 2 :: _STRIDE]
        output.mux(stream.encode())
