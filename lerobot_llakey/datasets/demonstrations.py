"""Writing simulated episodes as LeRobotDatasets: demonstrations (dense, videos) and keysteps (samples, images)."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from lerobot.configs import DepthEncoderConfig, RGBEncoderConfig
from lerobot.datasets.io_utils import write_info
from lerobot.datasets.utils import INFO_PATH

from lerobot_llakey import schema
from lerobot_llakey.datasets.episode_writer import EpisodeWriter, Statistics
from lerobot_llakey.datasets.video_file import VideoFile
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.cameras import CameraRig
from lerobot_llakey.sim.recorder import Episode, frame_columns, render_frames
from lerobot_llakey.sim.simulation import Simulation

ROBOT_TYPE = "panda"
_DEPTH_SCALE = ("depth_min", "depth_max", "use_log")
_ONE_BLOCK = 32
"""Pixels: x265's "lossless" alters a few depths of pictures that are one coding block of this size, unless told to cut
blocks smaller. Larger pictures keep its own choice, since files of one dataset share their headers."""

Frame = dict[str, Any]


def frames_of(simulation: Simulation, rig: CameraRig, episode: Episode, indices: Iterable[int]) -> list[Frame]:
    """Some frames of the episode that the simulation recorded last, as ``LeRobotDataset.add_frame`` takes them.

    Args:
        simulation: as the recorder left it.
        rig: cameras of the world's model.
        episode: what was recorded.
        indices: of the frames; repeated ones are rendered once.
    """
    wanted = list(indices)
    labels = episode.labels()
    rendered: dict[int, Frame] = {}
    for index, pictures in render_frames(simulation, rig, episode, sorted(set(wanted))):
        robot = {schema.STATE: episode.states[index], schema.VELOCITY: episode.velocities[index]}
        rendered[index] = frame_columns(pictures) | labels.row(index) | episode.origin() | robot
        rendered[index][schema.TASK] = episode.description
    return [dict(rendered[index]) for index in wanted]


def sim_features(image_size: int, dtype: str) -> dict[str, dict[str, Any]]:
    """LeRobot features of the simulator's datasets, with pictures of ``image_size`` squared; see the contract."""
    return schema.dataset_features(dict.fromkeys(schema.CAMERAS, (image_size, image_size)), dtype=dtype)


def rgb_encoder() -> RGBEncoderConfig:
    """H.264, which every browser plays: quick to encode, near lossless at 128 pixels."""
    return RGBEncoderConfig(vcodec="h264", preset="veryfast", crf=18, g=10)


def depth_encoder(size: Sequence[int] = (schema.IMAGE_SIZE, schema.IMAGE_SIZE)) -> DepthEncoderConfig:
    """Lossless 12-bit HEVC over the contract's depth range in linear steps of one millimetre: every depth is exact.

    Args:
        size: height and width of the pictures.
    """
    nearest, farthest = schema.DEPTH_RANGE_METRES
    # One thread: processes are what fills the cores.
    options = "lossless=1:log-level=error:pools=none:frame-threads=1"
    if min(size) <= _ONE_BLOCK:
        options += ":ctu=16"
    return DepthEncoderConfig(
        preset="ultrafast",
        g=10,
        depth_min=nearest,
        depth_max=farthest,
        use_log=False,
        extra_options={"x265-params": options},
    )


def check_depth(roots: Iterable[Path]) -> None:
    """Check that datasets keep depth as it is kept today, so that more episodes may be added.

    Raises:
        LlakeyError: if one, made by an earlier version, keeps it over another range.
    """
    encoder = depth_encoder()
    for root in roots:
        for key, feature in json.loads((root / INFO_PATH).read_text())["features"].items():
            info = feature.get("info") or {}
            kept = {name: info.get(f"video.{name}") for name in _DEPTH_SCALE}
            today = {name: getattr(encoder, name) for name in _DEPTH_SCALE}
            if "video.depth_min" in info and kept != today:
                raise LlakeyError(
                    f"Expected {key} in {root} with depth kept as {today}, got {kept} from an earlier version; collect "
                    "into a new folder."
                )


class DemonstrationWriter(EpisodeWriter):
    """Writes dense episodes to a new dataset whose pictures are videos; use it as a context manager.

    Args:
        repo_id: name of the dataset.
        root: folder, which must not exist yet.
        fps: frames a second.
        features: of the dataset.
    """

    def __init__(self, repo_id: str, root: Path, fps: int, features: Mapping[str, Mapping[str, Any]]) -> None:
        super().__init__(repo_id, root, fps, features, ROBOT_TYPE, use_videos=True)
        self._encoders = {
            key: depth_encoder(features[key]["shape"][:2]) if key in self.meta.depth_keys else rgb_encoder()
            for key in self._pictures
        }
        self._videos: dict[str, VideoFile] = {}
        self._numbers = dict.fromkeys(self._pictures, -1)

    def _write_pictures(self, frames: Sequence[Mapping[str, Any]]) -> tuple[dict[str, list[Any]], dict[str, Any]]:
        place: dict[str, Any] = {}
        for key, encoder in self._encoders.items():
            video = self._videos.get(key)
            if video is None or video.path.stat().st_size > self.meta.video_files_size_in_mb * 2**20:
                if video is not None:
                    video.close()
                self._numbers[key] += 1
                name = self.meta.video_path.format(video_key=key, chunk_index=0, file_index=self._numbers[key])
                video = self._videos[key] = VideoFile(self.meta.root / name, self.meta.fps, encoder)
            begin = video.frames
            video.add_episode([frame[key] for frame in frames])
            place |= {
                f"videos/{key}/chunk_index": 0,
                f"videos/{key}/file_index": self._numbers[key],
                f"videos/{key}/from_timestamp": begin / self.meta.fps,
                f"videos/{key}/to_timestamp": video.frames / self.meta.fps,
            }
        return {}, place

    def _picture_statistics(self, key: str, frames: Sequence[Mapping[str, Any]]) -> Statistics:
        """As elsewhere, but of videos LeRobot counts the pixels."""
        stats = super()._picture_statistics(key, frames)
        return stats | {"count": stats["count"] * int(np.prod(self.meta.features[key]["shape"][:2]))}

    def finalize(self) -> None:
        """Close all files; without it the dataset cannot be read."""
        for key, video in self._videos.items():
            video.close()
            self.meta.update_video_info(key, self._encoders[key])
        self._videos = {}
        write_info(self.meta.info, self.meta.root)
        super().finalize()


def keystep_rng(episode: Episode) -> np.random.Generator:
    """The generator that draws an episode's keysteps, fixed by its scene."""
    return np.random.default_rng((episode.seed, episode.variation))
