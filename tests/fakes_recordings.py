"""Small made-up recordings of arms that are not ours, as their owners would record them with LeRobot.

A hand moves above a coloured ball, down to it, and lifts it; it hesitates on the way, rests where it arrives, and all
sensors are noisy. Depth and colours show a table, the ball and the hand, rendered from the cameras' calibration.

    recording = fake_recording(tmp_path / "recording", "six_joints", scale=0.125)
    demonstrations = fake_demonstrations(tmp_path, "six_joints", scale=0.125)      # annotated
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes import BALL_RADIUS, COLOURS, looking_at, render_balls
from fakes_trajectories import KINDS, fake_trajectory, recorded_numbers
from lerobot_llakey import geometry, schema
from lerobot_llakey.datasets.annotate import annotate, find_keyframes
from lerobot_llakey.datasets.camera_calibration import read_calibration

_HAND_RADIUS, _HAND_COLOUR = 0.025, (0.3, 0.3, 0.35)


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
        poses, openings, commands, held = fake_trajectory(ball, arm.fps, rng)
        states, actions = (
            recorded_numbers(arm, poses, openings, rng),
            recorded_numbers(arm, poses, commands, None, arm.action),
        )
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
