"""The numbers of an RLBench demonstration in the terms of the data contract."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.converters.rlbench_files import EpisodeFolder
from lerobot_llakey.datasets.velocities import estimate_velocities
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import continuous_quaternions, matrix_to_pose

FPS = 20
"""RLBench records each of its simulator's steps, 50 ms apart."""
_JOINTS = 7
_FINGER_TRAVEL = 0.04
"""Metres that each of the Panda's two fingers travels."""
_ORTHOGONAL = 1e-3


@dataclass(frozen=True)
class CameraTrack:
    """A camera over one episode.

    Attributes:
        intrinsics: (T, 4) float32 fx, fy, cx, cy in pixels.
        extrinsics: (T, 7) float32, its pose in RLBench's world frame, OpenCV axes.
        near: (T,) metres to the near plane.
        far: (T,) metres to the far plane.
    """

    intrinsics: np.ndarray
    extrinsics: np.ndarray
    near: np.ndarray
    far: np.ndarray


@dataclass(frozen=True)
class Numbers:
    """All of an episode but its pictures.

    Attributes:
        states: (T, 15) float32, see schema.SIM_STATE_NAMES, in RLBench's world frame; quaternions without jumps.
        velocities: (T, 8) float32, see schema.SIM_VELOCITY_NAMES.
        gripper_open: (T,) bool, as RLBench has it: more than 0.9 of the way open.
        ignore_collision: (T,) bool, whether the planner may touch things on the way on from a frame.
        cameras: by name.
    """

    states: np.ndarray
    velocities: np.ndarray
    gripper_open: np.ndarray
    ignore_collision: np.ndarray
    cameras: dict[str, CameraTrack]


def read_numbers(folder: EpisodeFolder, observations: Sequence[Any]) -> Numbers:
    """Read an episode's numbers.

    Args:
        folder: whose cameras are wanted.
        observations: as the folder gives them.

    Raises:
        LlakeyError: naming the number that is missing, of another shape or not finite, and its time step.
    """

    def track(name: str, *shape: int) -> np.ndarray:
        return np.stack([_number(vars(one).get(name), shape, name, folder, at) for at, one in enumerate(observations)])

    gripper = track("gripper_open") > 0.5
    fingers = _optional(observations, "gripper_joint_positions")
    opening = gripper.astype(np.float64)
    if fingers:
        opening = (track("gripper_joint_positions", 2).mean(axis=1) / _FINGER_TRAVEL).clip(0, 1)
    pose = track("gripper_pose", 7)
    pose[:, 3:] = continuous_quaternions(pose[:, 3:] / np.linalg.norm(pose[:, 3:], axis=1, keepdims=True).clip(1e-9))
    joints, velocities = track("joint_positions", _JOINTS), track("joint_velocities", _JOINTS)
    opens = estimate_velocities(opening[:, None], FPS)
    # PerAct's fork of RLBench records whether the path to the next waypoint was planned past things; RLBench does not.
    ignores = (
        track("ignore_collisions") > 0.5 if _optional(observations, "ignore_collisions") else np.ones_like(gripper)
    )
    return Numbers(
        states=np.concatenate((pose, opening[:, None], joints), axis=1).astype(np.float32),
        velocities=np.concatenate((velocities, opens), axis=1).astype(np.float32),
        gripper_open=gripper,
        ignore_collision=ignores,
        cameras={camera: _camera(camera, folder, observations) for camera in folder.cameras},
    )


def opencv_camera(intrinsics: np.ndarray, extrinsics: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A CoppeliaSim camera with OpenCV's axes.

    There the camera's z axis points ahead as in OpenCV, but x to the left and y up; PyRep makes up for it by negative
    focal lengths. Half a turn about z gives positive ones: column = fx x / z + cx is the same number before and after.
    PyRep places pixel centres at whole numbers when it lifts depth, half a pixel off its own principal point of
    (W / 2, H / 2); here they are at half-integers, as the pictures are rendered.

    Args:
        intrinsics: (3, 3), focal lengths of either sign.
        extrinsics: (4, 4) camera-to-world.

    Returns:
        Intrinsics (4,) fx, fy, cx, cy and the pose (7,), both float32.

    Raises:
        LlakeyError: if they are no pinhole camera, or one that mirrors what it sees.
    """
    focal = intrinsics[[0, 1], [0, 1]]
    ideal = np.array([[focal[0], 0, intrinsics[0, 2]], [0, focal[1], intrinsics[1, 2]], [0, 0, 1]])
    rotation = extrinsics[:3, :3]
    flips = np.array([*np.sign(focal), 1.0])
    pinhole = np.allclose(intrinsics, ideal) and flips[0] * flips[1] == 1
    rigid = np.abs(rotation.T @ rotation - np.eye(3)).max() < _ORTHOGONAL and np.linalg.det(rotation) > 0
    if not pinhole or not rigid or not np.allclose(extrinsics[3], (0, 0, 0, 1)):
        raise LlakeyError(
            "Expected a pinhole camera with focal lengths of one sign and a rigid pose, got intrinsics "
            f"{intrinsics.tolist()} and extrinsics {extrinsics.tolist()}; fetch the episode anew."
        )
    turned = extrinsics.copy()
    turned[:3, :3] = rotation * flips
    numbers = np.array([*np.abs(focal), intrinsics[0, 2], intrinsics[1, 2]])
    return numbers.astype(np.float32), matrix_to_pose(turned).astype(np.float32)


def _camera(camera: str, folder: EpisodeFolder, observations: Sequence[Any]) -> CameraTrack:
    rows = []
    for at, one in enumerate(observations):
        misc = vars(one).get("misc")
        known = misc if isinstance(misc, dict) else {}
        name = f"{camera}_camera"
        wanted = {"intrinsics": (3, 3), "extrinsics": (4, 4), "near": (), "far": ()}
        inner, outer, near, far = (
            _number(known.get(f"{name}_{kind}"), shape, f"misc[{name}_{kind}]", folder, at)
            for kind, shape in wanted.items()
        )
        if not 0 <= near < far:
            raise LlakeyError(
                f"Expected planes with 0 <= near < far for {camera} at time step {at} of {folder.path}, got "
                f"{float(near):g} and {float(far):g} m; fetch it anew."
            )
        rows.append((*opencv_camera(inner, outer), near, far))
    intrinsics, extrinsics, nearest, farthest = (np.stack(column) for column in zip(*rows, strict=True))
    extrinsics[:, schema.QUATERNION] = continuous_quaternions(extrinsics[:, schema.QUATERNION], extrinsics[0, 3:])
    return CameraTrack(intrinsics, extrinsics, nearest, farthest)


def _optional(observations: Sequence[Any], name: str) -> bool:
    """Whether a number that some versions do not record is there."""
    return vars(observations[0]).get(name) is not None


def _number(value: Any, shape: tuple[int, ...], name: str, folder: EpisodeFolder, step: int) -> np.ndarray:
    try:
        number = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        number = np.array(np.nan)
    if number.size == int(np.prod(shape)) and np.isfinite(number).all():
        return number.reshape(shape)
    wanted = "x".join(map(str, shape)) or "one"
    raise LlakeyError(
        f"Expected {wanted} finite numbers as {name} at time step {step} of {folder.path}, got {value!r:.80}; record "
        "it with RLBench's generator, or fetch it anew."
    )
