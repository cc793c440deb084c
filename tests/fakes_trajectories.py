"""How made-up arms that are not ours move, and the numbers that their owners would record.

A hand moves above a ball, down to it, closes its gripper and lifts it. It hesitates on the way, rests where it arrives,
and all sensors are noisy.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from fakes import BALL_RADIUS
from lerobot_llakey import geometry, schema

_REST = (0.5, 0.9)
"""Seconds of a rest; people vary."""
_HESITATION = 0.12
"""Seconds of a stop that is no rest."""
SEGMENTS = 3
"""Keyframes of each episode: above the ball, at it, and up in the air."""


@dataclass(frozen=True)
class Kind:
    """An arm and how it is recorded.

    Attributes:
        fps: frames a second.
        state: names of the state's numbers.
        action: names of the recorded action's.
        cameras: height and width, and place in metres.
        calibrated: whether the recording holds the calibration, instead of a file.
        options: what ``find_keyframes`` has to be told.
    """

    fps: int
    state: tuple[str, ...]
    action: tuple[str, ...]
    cameras: Mapping[str, tuple[tuple[int, int], tuple[float, float, float]]]
    calibrated: bool
    options: Mapping[str, Any]


_SIX = tuple(f"joint_{number}" for number in range(1, 7))
_FIVE = ("shoulder_pan.pos", "shoulder_lift.pos", "elbow_flex.pos", "wrist_flex.pos", "wrist_roll.pos")
KINDS: dict[str, Kind] = {
    "six_joints": Kind(
        15,
        (*_SIX, "ee.x", "ee.y", "ee.z", "ee.wx", "ee.wy", "ee.wz", "ee.gripper_pos"),
        (*_SIX, "gripper_pos"),
        {"front": ((480, 640), (0.95, 0.1, 0.55))},
        False,
        {},
    ),
    "five_joints": Kind(
        30,
        (*_FIVE, "jaw", "tcp_qw", "tcp_qx", "tcp_qy", "tcp_qz", "tcp_x", "tcp_y", "tcp_z"),
        (*_FIVE, "jaw"),
        {"top": ((480, 640), (0.3, 0.0, 0.75)), "side": ((240, 424), (0.35, -0.6, 0.4))},
        True,
        {"gripper": "jaw", "gripper_range": (0.0, 100.0)},
    ),
    "hand_alone": Kind(10, schema.POSE_NAMES, schema.POSE_NAMES, {"phone": ((240, 320), (0.8, -0.3, 0.5))}, False, {}),
}
"""A UR3 or the like with an RGB-D camera; an SO-101 or the like, with two of them, joints in degrees and a gripper of
another name; a hand of which the pose alone is known."""


def fake_trajectory(
    ball: np.ndarray, fps: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Poses (T, 7), openings (T,), commanded openings (T,) and whether the ball is held (T,)."""
    top = ball + (0, 0, BALL_RADIUS)
    yaw = rng.uniform(-0.8, 0.8)
    here = np.array([0.2, -0.05, 0.32]) + rng.normal(0, 0.01, 3), 0.0
    places, yaws, openings, commands, held = [here[0]], [here[1]], [1.0], [1.0], [False]

    def stay(seconds: float, command: float, opening: float | None = None) -> None:
        for u in np.linspace(0, 1, max(1, round(seconds * fps)) + 1)[1:]:
            places.append(places[-1])
            yaws.append(yaws[-1])
            openings.append(openings[-1] if opening is None else openings[-1] + u * (opening - openings[-1]))
            commands.append(command)
            held.append((command < 0.5 and u == 1) or held[-1])

    def go(place: np.ndarray, turn: float) -> None:
        start, first = places[-1], yaws[-1]
        frames = max(3, round(np.linalg.norm(place - start) / rng.uniform(0.12, 0.2) * fps))
        hesitates = frames // 2 if rng.random() < 0.5 else 0
        for frame in range(1, frames + 1):
            u = frame / frames
            s = 10 * u**3 - 15 * u**4 + 6 * u**5
            places.append(start + s * (place - start))
            yaws.append(first + s * (turn - first))
            openings.append(openings[-1])
            commands.append(commands[-1])
            held.append(held[-1])
            if frame == hesitates:
                stay(_HESITATION, commands[-1])

    stay(rng.uniform(*_REST), 1.0)
    go(top + (0, 0, 0.12), yaw)
    stay(rng.uniform(*_REST), 1.0)
    go(top, yaw)
    stay(0.35, 0.0, 0.45)  # the ball keeps the gripper from closing
    stay(rng.uniform(*_REST), 0.0)
    go(top + (0, 0, 0.18), yaw)
    stay(rng.uniform(*_REST), 0.0)
    down = Rotation.from_quat(geometry.DOWN)
    quaternions = (Rotation.from_euler("z", np.array(yaws)[:, None]) * down).as_quat()
    return np.column_stack((places, quaternions)), np.array(openings), np.array(commands), np.array(held)


def recorded_numbers(
    arm: Kind, poses: np.ndarray, openings: np.ndarray, rng: np.random.Generator | None, names: tuple[str, ...] = ()
) -> np.ndarray:
    """The named numbers (T, N) float32; with noise where there is a source of it."""

    def noise(shape: tuple[int, ...], sigma: float) -> np.ndarray:
        return np.zeros(shape) if rng is None else rng.normal(0, sigma, shape)

    frames = len(poses)
    place = poses[:, :3] + noise((frames, 3), 4e-4)
    turn = Rotation.from_rotvec(noise((frames, 3), 1e-3)) * Rotation.from_quat(poses[:, 3:])
    known = dict(zip(schema.POSE_NAMES, np.column_stack((place, turn.as_quat())).T, strict=True))
    known |= dict(zip(("wx", "wy", "wz"), turn.as_rotvec().T, strict=True))
    known |= {name: openings + noise((frames,), 2e-3) for name in ("gripper_pos", "jaw")}
    known["jaw"] = 100 * known["jaw"]
    # An arm of no particular kinematics: joints that follow the hand.
    yaw = (Rotation.from_quat(poses[:, 3:]) * Rotation.from_quat(geometry.DOWN).inv()).as_rotvec()[:, 2:]
    mixing = np.random.default_rng(7).uniform(1.0, 3.0, (4, 6)) * np.random.default_rng(8).choice([-1, 1], (4, 6))
    joints = np.column_stack((poses[:, :3], yaw)) @ mixing + noise((frames, 6), 5e-4)
    known |= dict(zip(_SIX, joints.T, strict=True)) | dict(zip(_FIVE, np.rad2deg(joints[:, :5]).T, strict=True))
    plain = [name.removeprefix("ee.").removeprefix("tcp_") for name in names or arm.state]
    return np.column_stack([known[name] for name in plain]).astype(np.float32)
