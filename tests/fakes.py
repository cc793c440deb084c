"""Small made-up keysteps datasets in the data contract, so that policies and tools are tested without a simulator.

Use it from a test with ``from fakes import fake_keysteps``: pytest's ``pythonpath`` setting holds this folder (the name
``tests`` itself is taken by other distributions).

"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from scipy.spatial.transform import Rotation

from lerobot_llakey import geometry, schema

COLOURS: dict[str, tuple[float, float, float]] = {
    "red": (0.9, 0.1, 0.1),
    "green": (0.1, 0.8, 0.1),
    "blue": (0.1, 0.2, 0.9),
    "yellow": (0.9, 0.9, 0.1),
}
BALL_RADIUS = 0.04
_TARGET = np.array([0.5, 0.0, 0.0])
_EYES = ((1.3, 0.0, 0.7), (0.2, 0.7, 0.8), (0.2, -0.7, 0.8), (0.45, 0.0, 0.8))


def fake_cameras(image_size: int, count: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Intrinsics (C, 4) and poses (C, 7) in the base frame of fixed cameras that look at the table."""
    intrinsics = np.stack([geometry.pinhole_intrinsics(50.0, image_size, image_size)] * count)
    extrinsics = np.stack([looking_at(np.array(_EYES[index % len(_EYES)]), _TARGET) for index in range(count)])
    return intrinsics.astype(np.float32), extrinsics.astype(np.float32)


def looking_at(eye: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Pose (7,) of a camera at ``eye`` that looks at ``target``, upright, in OpenCV axes."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    turn = Rotation.from_matrix(np.stack((right, np.cross(forward, right), forward), axis=1))
    return np.concatenate((eye, turn.as_quat()))


def render_balls(
    centres: np.ndarray,
    colours: np.ndarray,
    intrinsics: np.ndarray,
    extrinsics: np.ndarray,
    image_size: int | tuple[int, int],
    radius: float = BALL_RADIUS,
) -> tuple[np.ndarray, np.ndarray]:
    """Ray-cast balls (N, 3) of colours (N, 3) in 0..1 on a grey table.

    Args:
        centres: metres.
        colours: of the balls.
        intrinsics: (4,) of the camera.
        extrinsics: (7,) of the camera.
        image_size: height and width, or both in one number.
        radius: of the balls, metres.

    Returns:
        RGB uint8 (H, W, 3) and z-depth uint16 (H, W, 1) in millimetres (0 where nothing is hit).
    """
    height, width = (image_size, image_size) if isinstance(image_size, int) else image_size
    focal_x, focal_y, centre_x, centre_y = intrinsics.astype(float)
    u, v = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    rays = np.stack(((u - centre_x) / focal_x, (v - centre_y) / focal_y, np.ones_like(u)), -1)
    rays = rays @ Rotation.from_quat(extrinsics[3:]).as_matrix().T
    eye = extrinsics[:3].astype(float)
    with np.errstate(divide="ignore"):
        depth = np.where(rays[..., 2] < 0, -eye[2] / rays[..., 2], np.inf)
    colour = np.full((height, width, 3), 0.5)
    for centre, paint in zip(centres, colours, strict=True):
        offset = eye - centre
        a, b = (rays * rays).sum(-1), (rays * offset).sum(-1)
        discriminant = b * b - a * (offset @ offset - radius**2)
        hit = (-b - np.sqrt(np.maximum(discriminant, 0.0))) / a
        nearer = (discriminant > 0) & (hit > 0) & (hit < depth)
        depth = np.where(nearer, hit, depth)
        colour[nearer] = paint
    millimetres = np.where(depth < 3.0, depth * 1000.0, 0.0)
    return (colour * 255).round().astype(np.uint8), millimetres.round().astype(np.uint16)[..., None]


def fake_frame(
    rng: np.random.Generator, image_size: int = 32, cameras: Sequence[str] = schema.CAMERAS
) -> dict[str, Any]:
    """One random observation (numpy, as ``LeRobotDataset.add_frame`` takes it) with two balls, without an action.

    Also holds the private keys ``_names`` (the balls' colours) and ``_centres`` ((2, 3) metres).
    """
    intrinsics, extrinsics = fake_cameras(image_size, len(cameras))
    names = list(rng.permutation(list(COLOURS))[:2])
    centres = np.stack((rng.uniform(0.35, 0.65, 2), rng.uniform(0.05, 0.25, 2) * [1, -1], [BALL_RADIUS] * 2), axis=1)
    frame: dict[str, Any] = {
        schema.STATE: np.array([0.4, 0, 0.5, 1, 0, 0, 0, 1, 0, 0, 0, -1.5, 0, 1.5, 0.8], dtype=np.float32),
        "_names": names,
        "_centres": centres,
    }
    paints = np.array([COLOURS[name] for name in names])
    for index, camera in enumerate(cameras):
        rgb, depth = render_balls(centres, paints, intrinsics[index], extrinsics[index], image_size)
        frame[schema.image_key(camera)], frame[schema.depth_key(camera)] = rgb, depth
        frame[schema.intrinsics_key(camera)] = intrinsics[index]
        frame[schema.extrinsics_key(camera)] = extrinsics[index]
    return frame


def fake_action(position: np.ndarray, gripper_open: bool, yaw: float = 0.0) -> np.ndarray:
    """A keyframe action (9,) float32 pointing straight down at a position in metres."""
    tail = (float(gripper_open), float(not gripper_open))
    return np.concatenate((position, geometry.top_down(yaw), tail)).astype(np.float32)


def _at(state: np.ndarray, reached: Sequence[np.ndarray]) -> np.ndarray:
    """The state (15,) of a hand that has reached these actions (9,), and stays at the last one."""
    last = reached[-1][: schema.GRIPPER + 1] if reached else state[: schema.GRIPPER + 1]
    return np.concatenate((last, state[schema.GRIPPER + 1 :])).astype(np.float32)


def fake_keysteps(
    root: str | Path,
    episodes: int = 2,
    frames: int = 6,
    image_size: int = 32,
    cameras: Sequence[str] = schema.CAMERAS,
    repo_id: str = "llakey/fake_keysteps",
    seed: int = 0,
    without: Sequence[str] = (),
) -> LeRobotDataset:
    """Write and reopen a keysteps dataset: each episode first goes above a coloured ball, then grasps it.

    Args:
        root: folder of the dataset; must not exist yet.
        episodes: number of episodes, one random scene each.
        frames: frames an episode, at least 2; keyframes are the middle and the last one.
        image_size: height and width of every camera in pixels.
        cameras: names of the cameras.
        repo_id: the dataset's name; nothing is downloaded or pushed.
        seed: of the scenes.
        without: feature names to leave out, for tests of bad input.

    Returns:
        The dataset, reopened for reading.
    """
    features = schema.dataset_features(dict.fromkeys(cameras, (image_size, image_size)), dtype="image")
    features = {key: value for key, value in features.items() if key not in without}
    dataset = LeRobotDataset.create(repo_id, fps=10, features=features, root=root, use_videos=False)
    rng = np.random.default_rng(seed)
    keyframes = (frames // 2, frames - 1)
    for episode in range(episodes):
        scene = fake_frame(rng, image_size, cameras)
        name, centre = scene.pop("_names")[0], scene.pop("_centres")[0]
        steps = (
            (f"move to the top of the {name} block", fake_action(centre + [0.0, 0.0, 0.15], gripper_open=True)),
            (f"grasp the {name} block", fake_action(centre, gripper_open=False)),
        )
        for index in range(frames):
            segment = int(index >= keyframes[0])
            is_keyframe = index in keyframes
            previous = steps[0][0] if index == keyframes[0] else "" if index == 0 else steps[segment][0]
            reached = [action for (_, action), keyframe in zip(steps, keyframes, strict=True) if keyframe <= index]
            frame = dict(scene) | {
                schema.STATE: _at(scene[schema.STATE], reached),
                # It stands at the start and at keyframes.
                schema.VELOCITY: np.full(
                    len(schema.SIM_VELOCITY_NAMES), 0.0 if is_keyframe or index == 0 else 0.3, np.float32
                ),
                schema.ACTION: steps[segment][1],
                schema.INSTRUCTION: steps[segment][0],
                schema.PREVIOUS_INSTRUCTION: previous,
                schema.STEP: np.array([segment], dtype=np.float32),
                schema.IS_KEYFRAME: np.array([is_keyframe]),
                schema.KEYFRAME_INDEX: np.array([segment]),
                schema.NEXT_KEYFRAME: np.array([keyframes[segment]]),
                schema.EPISODE_SEED: np.array([schema.scene_seed("train", episode)]),
                schema.EPISODE_VARIATION: np.array([0]),
                schema.EPISODE_SEQUENCE: np.array([0]),
                schema.EPISODE_TASK: "pick_up",
                schema.EPISODE_EVENT: "",
            }
            kept = {key: value for key, value in frame.items() if key in features}
            dataset.add_frame(kept | {schema.TASK: f"pick up the {name} block"})
        dataset.save_episode()
    dataset.finalize()
    return LeRobotDataset(repo_id, root=root)
