"""Small made-up recordings of arms that are not ours, as their owners would record them with LeRobot.

A hand moves above a coloured ball, down to it, and lifts it; it hesitates on the way, rests where it arrives, and all
sensors are noisy. Depth and colours show a table, the ball and the hand, rendered from the cameras' calibration.

    recording = fake_recording(tmp_path / "recording", "six_joints", scale=0.125)
    demonstrations = fake_demonstrations(tmp_path, "six_joints", scale=0.125)      # annotated
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from scipy.spatial.transform import Rotation

from fakes import BALL_RADIUS, COLOURS, looking_at, render_balls
from lerobot_llakey import geometry, schema
from lerobot_llakey.datasets.annotate import annotate, find_keyframes
from lerobot_llakey.datasets.camera_calibration import read_calibration

_HAND_RADIUS, _HAND_COLOUR = 0.025, (0.3, 0.3, 0.35)
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


def fake_recording(
    root: Path, kind: str = "six_joints", episodes: int = 2, seed: int = 0, *, scale: float = 1.0, video: bool = False
) -> LeRobotDataset:
    """Write and reopen a recording.

    Args:
        root: folder of the dataset; must not exist yet.
        kind: one of KINDS.
        episodes: number of episodes, one random place and colour of the ball each; each lasts about six seconds.
        seed: of everything.
        scale: of the pictures, 0.125 for 80x60 pixels in place of 640x480.
        video: whether pictures are stored as videos.
    """
    arm, dtype, axes = KINDS[kind], "video" if video else "image", ["height", "width", "channels"]
    features: dict[str, dict[str, Any]] = {
        schema.STATE: schema.vector(arm.state),
        schema.ACTION: schema.vector(arm.action),
    }
    for camera in arm.cameras:
        height, width = _size(kind, camera, scale)
        features[schema.image_key(camera)] = {"dtype": dtype, "shape": (height, width, 3), "names": axes}
        depth = {"dtype": dtype, "shape": (height, width, 1), "names": axes, "info": {"is_depth_map": True}}
        features[schema.depth_key(camera)] = depth
        if arm.calibrated:
            features[schema.intrinsics_key(camera)] = schema.vector(schema.INTRINSICS_NAMES)
            features[schema.extrinsics_key(camera)] = schema.vector(schema.POSE_NAMES)
    dataset = LeRobotDataset.create(f"me/{kind}", arm.fps, features, root=root, use_videos=video, robot_type=kind)
    rng = np.random.default_rng(seed)
    for colour, ball in _scenes(episodes, seed):
        poses, openings, commands, held = _trajectory(ball, arm.fps, rng)
        states, actions = _numbers(arm, poses, openings, rng), _numbers(arm, poses, commands, None, arm.action)
        for frame, pose in enumerate(poses):
            balls = np.stack((pose[:3] - (0, 0, BALL_RADIUS) if held[frame] else ball, pose[:3]))
            row = {
                schema.STATE: states[frame],
                schema.ACTION: actions[frame],
                schema.TASK: f"pick up the {colour} block",
            }
            for camera in arm.cameras:
                intrinsics, extrinsics = calibration_of(kind, camera, scale)
                seen = _picture(kind, camera, scale, balls, colour, rng)
                row[schema.image_key(camera)], row[schema.depth_key(camera)] = seen
                if arm.calibrated:
                    row |= {schema.intrinsics_key(camera): intrinsics, schema.extrinsics_key(camera): extrinsics}
            dataset.add_frame(row)
        dataset.save_episode()
    dataset.finalize()
    return LeRobotDataset(f"me/{kind}", root=root)


def fake_demonstrations(
    root: Path, kind: str = "six_joints", episodes: int = 2, seed: int = 0, *, scale: float = 1.0, video: bool = False
) -> LeRobotDataset:
    """A recording under ``root / "recording"``, annotated under ``root / "demonstrations"``."""
    source = fake_recording(root / "recording", kind, episodes, seed, scale=scale, video=video)
    found = find_keyframes(source, **KINDS[kind].options)
    calibration = {}
    if not KINDS[kind].calibrated:
        path = write_calibration(root / "calibration.yaml", kind, scale)
        calibration = read_calibration(path, KINDS[kind].cameras)
    texts = instructions_of(episodes, seed)
    return annotate(source, found, texts, root / "demonstrations", "me/demonstrations", calibration=calibration)


def instructions_of(episodes: int = 2, seed: int = 0) -> dict[int, list[str]]:
    """What a person would fill in."""
    return {
        episode: [f"move to the top of the {colour} block", f"grasp the {colour} block", "raise the robotic arm"]
        for episode, (colour, _) in enumerate(_scenes(episodes, seed))
    }


def calibration_of(kind: str, camera: str, scale: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Intrinsics (4,) and pose (7,) of a camera, float32."""
    intrinsics = geometry.pinhole_intrinsics(48.0, *_size(kind, camera, scale))
    extrinsics = looking_at(np.array(KINDS[kind].cameras[camera][1]), np.array([0.3, 0.02, 0.08]))
    return intrinsics.astype(np.float32), extrinsics.astype(np.float32)


def write_calibration(path: Path, kind: str, scale: float = 1.0) -> Path:
    """The file of calibration that a person would write."""
    content = {}
    for camera in KINDS[kind].cameras:
        intrinsics, extrinsics = calibration_of(kind, camera, scale)
        content[camera] = {"intrinsics": intrinsics.tolist(), "extrinsics": extrinsics.tolist()}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(yaml.safe_dump(content))
    return path


def _scenes(episodes: int, seed: int) -> list[tuple[str, np.ndarray]]:
    rng = np.random.default_rng((seed, 1))
    places = np.column_stack((rng.uniform(0.22, 0.38, episodes), rng.uniform(-0.1, 0.14, episodes)))
    return [(str(rng.choice(list(COLOURS))), np.array([*place, BALL_RADIUS])) for place in places]


def _size(kind: str, camera: str, scale: float) -> tuple[int, int]:
    height, width = KINDS[kind].cameras[camera][0]
    return round(height * scale), round(width * scale)


def _trajectory(
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


def _numbers(
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


def _picture(
    kind: str, camera: str, scale: float, places: np.ndarray, colour: str, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """What a cheap camera sees of the ball and the hand: RGB uint8 and depth uint16 in millimetres, with holes."""
    paints = np.array([COLOURS[colour], _HAND_COLOUR])
    radii = np.array([BALL_RADIUS, _HAND_RADIUS])
    rgb, depth = render_balls(places, paints, *calibration_of(kind, camera, scale), _size(kind, camera, scale), radii)
    rgb = (rgb + rng.normal(0, 3, rgb.shape)).clip(0, 255).astype(np.uint8)
    noisy = depth + rng.normal(0, 1.5, depth.shape)
    noisy[(rng.random(depth.shape) < 0.02) | (depth == 0)] = 0
    return rgb, noisy.clip(0, 4095).round().astype(np.uint16)
