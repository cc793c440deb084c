"""Writing simulated episodes as LeRobotDatasets: demonstrations (dense, videos) and keysteps (samples, images)."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
from lerobot.configs import DepthEncoderConfig, RGBEncoderConfig
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.datasets.utils import INFO_PATH

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.cameras import CameraRig
from lerobot_llakey.sim.recorder import Episode, frame_columns, render_frames
from lerobot_llakey.sim.simulation import Simulation

ROBOT_TYPE = "panda"
_DEPTH_SCALE = ("depth_min", "depth_max", "use_log")
_LONGEST_EPISODE = 100_000
"""LeRobot's streaming encoder drops frames once its queue is full, so the queue holds whole episodes."""

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


def depth_encoder() -> DepthEncoderConfig:
    """Lossless 12-bit HEVC over the contract's depth range in linear steps of one millimetre: every depth is exact."""
    nearest, farthest = schema.DEPTH_RANGE_METRES
    # One thread a stream: eight streams are encoded at once.
    options = {"x265-params": "lossless=1:log-level=error:pools=none:frame-threads=1"}
    return DepthEncoderConfig(
        preset="ultrafast", g=10, depth_min=nearest, depth_max=farthest, use_log=False, extra_options=options
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


class DemonstrationWriter:
    """Writes dense episodes to a new dataset whose pictures are videos; use it as a context manager.

    Args:
        repo_id: name of the dataset.
        root: folder, which must not exist yet.
        fps: frames a second.
        features: of the dataset.
    """

    def __init__(self, repo_id: str, root: Path, fps: int, features: Mapping[str, Mapping[str, Any]]) -> None:
        self._dataset = LeRobotDataset.create(
            repo_id,
            fps,
            {key: dict(feature) for key, feature in features.items()},
            root=root,
            robot_type=ROBOT_TYPE,
            rgb_encoder=rgb_encoder(),
            depth_encoder=depth_encoder(),
            streaming_encoding=True,
            encoder_queue_maxsize=_LONGEST_EPISODE,
            encoder_threads=1,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._dataset.finalize()

    def add_episode(self, frames: Iterable[Frame]) -> None:
        """Write one episode of frames as :func:`frames_of` gives them."""
        for frame in frames:
            self._dataset.add_frame(dict(frame))
        self._dataset.save_episode()


def keystep_rng(episode: Episode) -> np.random.Generator:
    """The generator that draws an episode's keysteps, fixed by its scene."""
    return np.random.default_rng((episode.seed, episode.variation))
