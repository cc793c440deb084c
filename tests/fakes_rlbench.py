"""Demonstrations in RLBench's layout, written from the simulator's own episodes, so that their geometry is true.

The pickles name the classes of modules that are called as RLBench's are; these exist only while they are written.
"""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from PIL import Image

from lerobot_llakey import schema
from lerobot_llakey.geometry import pose_to_matrix
from lerobot_llakey.sim.cameras import RGBD, CameraRig
from lerobot_llakey.sim.recorder import Episode, record, render_frames
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task

NEAR, FAR = 0.01, 4.5
FPS = 20


@dataclass
class RecordedFrames:
    """Frames of an episode.

    Attributes:
        episode: all of it.
        steps: the frames that count.
        pictures: of these, by camera.
        keyframes: the experts' keyframes among them.
    """

    episode: Episode
    steps: list[int]
    pictures: list[dict[str, RGBD]]
    keyframes: list[int]


def recorded_frames(
    task: str = "open_drawer", seed: int = 1, size: int = 32, cameras: Sequence[str] = ("front", "wrist")
) -> RecordedFrames:
    """An expert's episode without its rests, of which the keyframes alone are kept: RLBench's arms hardly wait."""
    simulation = Simulation(make_task(task))
    rig = CameraRig(simulation.world.model, size)
    episode = record(simulation, seed, fps=FPS)
    moving = np.abs(episode.velocities[:, :7]).max(axis=1) > 0.1
    steps = sorted({0, *np.flatnonzero(moving).tolist(), *episode.keyframes})
    pictures = [
        {camera: RGBD(*(np.array(part) for part in vars(one[camera]).values())) for camera in cameras}
        for _, one in render_frames(simulation, rig, episode, steps)
    ]
    return RecordedFrames(episode, steps, pictures, [steps.index(frame) for frame in episode.keyframes])


@contextmanager
def stand_in_modules() -> Any:
    """RLBench's modules with its two classes, for as long as pickles are written."""
    names = ("rlbench", "rlbench.demo", "rlbench.backend", "rlbench.backend.observation")
    before = {name: sys.modules.get(name) for name in names}
    for name in names:
        sys.modules[name] = ModuleType(name)
    for module, name in (("rlbench.demo", "Demo"), ("rlbench.backend.observation", "Observation")):
        made = type(name, (), {"__module__": module})
        setattr(sys.modules[module], name, made)
    try:
        yield sys.modules["rlbench.demo"].Demo, sys.modules["rlbench.backend.observation"].Observation
    finally:
        for name, module in before.items():
            sys.modules.pop(name) if module is None else sys.modules.__setitem__(name, module)


def write_episode(
    folder: Path,
    frames: RecordedFrames,
    *,
    skills: Sequence[str] | None = None,
    protocol: int = 4,
    change: Callable[[list[Any]], None] = lambda observations: None,
) -> Path:
    """One episode's folder.

    Args:
        folder: ``.../episodes/episodeN``.
        frames: what was recorded.
        skills: the skill instructions; the episode's own where None.
        protocol: of the pickles.
        change: what to do to the observations before they are written.
    """
    episode = frames.episode
    with stand_in_modules() as (demo_class, observation_class):
        observations = []
        for step, (frame, pictures) in enumerate(zip(frames.steps, frames.pictures, strict=True)):
            state = episode.states[frame].astype(np.float64)
            one = observation_class()
            one.gripper_pose = state[:7]
            one.gripper_open = float(state[schema.GRIPPER] > 0.9)
            one.gripper_joint_positions = np.full(2, 0.04 * state[schema.GRIPPER], dtype=np.float32)
            one.joint_positions, one.joint_velocities = state[8:15], episode.velocities[frame][:7]
            one.ignore_collisions = np.bool_(True)
            one.front_rgb = None
            one.misc = {"variation_index": np.int64(episode.variation)}
            for camera, picture in pictures.items():
                one.misc |= rlbench_camera(camera, picture.intrinsics, picture.pose)
                save(folder / f"{camera}_rgb" / f"{step}.png", picture.rgb)
                save(folder / f"{camera}_depth" / f"{step}.png", encode_depth(picture.depth / 1000))
            observations.append(one)
        change(observations)
        demo = demo_class()
        demo._observations = observations
        demo.random_seed = np.random.RandomState(0).get_state()
        for name, content in (
            ("low_dim_obs.pkl", demo),
            ("variation_descriptions.pkl", list(skills or [episode.description])),
            ("variation_number.pkl", episode.variation),
        ):
            (folder / name).write_bytes(pickle.dumps(content, protocol))
    return folder


def rlbench_camera(camera: str, intrinsics: np.ndarray, pose: np.ndarray) -> dict[str, Any]:
    """What RLBench's ``misc`` says of a camera: negative focal lengths, x to the left, y up."""
    fx, fy, cx, cy = intrinsics.astype(np.float64)
    matrix = pose_to_matrix(np.asarray(pose, dtype=np.float64))
    matrix[:3, :2] *= -1
    return {
        f"{camera}_camera_intrinsics": np.array([[-fx, 0, cx], [0, -fy, cy], [0, 0, 1]]),
        f"{camera}_camera_extrinsics": matrix,
        f"{camera}_camera_near": NEAR,
        f"{camera}_camera_far": FAR,
    }


def encode_depth(metres: np.ndarray) -> np.ndarray:
    """Depth as RLBench saves it: the share of the way from the near to the far plane in 24 bits of a colour."""
    share = ((metres.astype(np.float64) - NEAR) / (FAR - NEAR)).clip(0, 1)
    number = np.floor(share * (2**24 - 1) + 0.5).astype(np.int64)
    return np.stack((number >> 16, (number >> 8) & 255, number & 255), axis=-1).astype(np.uint8)


def save(path: Path, pixels: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(path)
