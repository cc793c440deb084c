"""The data contract: every feature name, shape and unit that datasets, policies and environments share.

Nothing else in the package spells a feature name. Conventions: metres and radians in the robot's base frame,
quaternions xyzw with w >= 0, depth as metric z-depth in float32 millimetres, cameras in OpenCV frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lerobot_llakey.errors import LlakeyError

CAMERAS: tuple[str, ...] = ("front", "left_shoulder", "right_shoulder", "wrist")
"""Order of the cameras wherever something is stacked over cameras."""

STATE = "observation.state"
ACTION = "action"
INTRINSICS = "observation.camera_intrinsics"
EXTRINSICS = "observation.camera_extrinsics"
INSTRUCTION = "observation.instruction"
PREVIOUS_INSTRUCTION = "observation.previous_instruction"
"""The instruction last commanded when the frame was taken: the finished one at a keyframe, else the current one."""
STEP = "observation.step"
"""Number of keyframe actions taken before the frame, float32 (1,): the timestep that RVT is given."""
ORACLE_INSTRUCTION = "observation.oracle_instruction"
"""The expert's instruction from the present state, as the code points of :func:`encode_text`."""
VELOCITY = "observation.velocity"
"""How fast the joints turn (radians a second) and the gripper opens (opening, 0..1, a second), float32 (8,)."""
SAMPLE_WEIGHT = "observation.sample_weight"
"""Optional weight of a training sample, float32 (1,)."""
IS_KEYFRAME = "keyframe.is_keyframe"
KEYFRAME_INDEX = "keyframe.index"
NEXT_KEYFRAME = "keyframe.next_frame"
EPISODE_SEED = "episode.seed"
EPISODE_VARIATION = "episode.variation"
EPISODE_SEQUENCE = "episode.sequence"
EPISODE_TASK = "episode.task"
"""Name of the simulator's task; "" for recordings of a real robot."""
EPISODE_EVENT = "episode.event"
"""What disturbed the episode and can be seen from this frame on (an unforeseen event); "" before it or without one."""
ORIGIN_COLUMNS = (EPISODE_TASK, EPISODE_EVENT)
"""What an episode was; nothing that trains a policy needs them."""
LATER_COLUMNS = (*ORIGIN_COLUMNS, VELOCITY)
"""Columns that the first datasets lack."""
TASK = "task"

STATE_NAMES: tuple[str, ...] = (
    *("x", "y", "z", "qx", "qy", "qz", "qw", "gripper_opening"),
    *(f"joint_{i}" for i in range(1, 8)),
)
ACTION_NAMES: tuple[str, ...] = ("x", "y", "z", "qx", "qy", "qz", "qw", "gripper_open", "ignore_collision")
VELOCITY_NAMES: tuple[str, ...] = (*(f"joint_{i}_velocity" for i in range(1, 8)), "gripper_velocity")
STATE_DIM = len(STATE_NAMES)
VELOCITY_DIM = len(VELOCITY_NAMES)
ACTION_DIM = len(ACTION_NAMES)

POSITION = slice(0, 3)
QUATERNION = slice(3, 7)
GRIPPER = 7
"""Column of the gripper in both state (opening, 0..1) and action (1 = open)."""
JOINTS = slice(8, 15)
ARM_VELOCITY, GRIPPER_VELOCITY = slice(0, 7), 7
"""Columns of a velocity."""
IGNORE_COLLISION = 8
"""Column of the collision flag in the action: 1 = the planner may touch things."""

IMAGE_SIZE = 128
DEPTH_RANGE_METRES = (0.0, 4.095)
"""Range of the depth videos: their 12 bits hold every whole millimetre from 0, which is not measured, to 4.095 m.

The cameras' near plane and all that a policy acts on lie within it; what is farther away counts as 4.095 m.
"""

Workspace = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
WORKSPACE: Workspace = ((0.0, 1.0), (-0.5, 0.5), (-0.05, 0.95))
"""Default bounds (metres) of x, y and z in which keyframes and point clouds live."""

UNIT_TOLERANCE = 0.02
"""By how much a quaternion's length may differ from 1; recorded ones are rounded."""
FARTHEST = 10.0
"""Metres from the base beyond which no arm reaches: such a position is in another unit."""

TEXT_LENGTH = 160
"""Length in code points of an encoded text."""

_CODE_POINTS = 0x110000
"""How many code points there may be."""

SEED_RANGES: dict[str, range] = {
    "train": range(0, 100_000_000),
    "val": range(100_000_000, 200_000_000),
    "test": range(200_000_000, 300_000_000),
}
"""Scene seeds of training, validation and test: disjoint, so that no test scene is ever trained on."""


def image_key(camera: str) -> str:
    """Feature name of a camera's RGB image."""
    return f"observation.images.{camera}"


def depth_key(camera: str) -> str:
    """Feature name of a camera's depth map."""
    return f"observation.images.{camera}_depth"


def scene_seed(split: str, index: int) -> int:
    """The scene seed of the ``index``-th episode of a split.

    Raises:
        LlakeyError: if the split is unknown or the index falls outside its range.
    """
    if split not in SEED_RANGES:
        raise LlakeyError(f"Expected a split out of {sorted(SEED_RANGES)}, got {split!r}; pick one of these.")
    seeds = SEED_RANGES[split]
    if not 0 <= index < len(seeds):
        raise LlakeyError(f"Expected an episode index in [0, {len(seeds)}), got {index}; choose a smaller seed.")
    return seeds[index]


def encode_text(text: str) -> np.ndarray:
    """Text as float32 code points of shape (TEXT_LENGTH,), zero-padded: the form in which LeRobot passes arrays on.

    Raises:
        LlakeyError: if the text is longer than TEXT_LENGTH.
    """
    if len(text) > TEXT_LENGTH:
        raise LlakeyError(f"Expected at most {TEXT_LENGTH} characters, got {len(text)}: {text!r}; shorten it.")
    codes = np.zeros(TEXT_LENGTH, dtype=np.float32)
    codes[: len(text)] = [ord(character) for character in text]
    return codes


def decode_text(codes: Any) -> str:
    """Inverse of :func:`encode_text` for one array or tensor of shape (TEXT_LENGTH,).

    Raises:
        LlakeyError: if a number is no code point.
    """
    numbers = np.asarray(codes, dtype=np.float64).reshape(-1)
    wrong = ~((numbers >= 0) & (numbers < _CODE_POINTS) & (numbers == np.floor(numbers)))  # NaN is wrong
    if wrong.any():
        raise LlakeyError(
            f"Expected a text as code points from 0 to {_CODE_POINTS - 1}, got {numbers[wrong][0]:g} at place "
            f"{int(wrong.argmax())}; make it with schema.encode_text."
        )
    return "".join(chr(int(number)) for number in numbers if number > 0)


def _image_features(cameras: Sequence[str], height: int, width: int, dtype: str) -> dict[str, dict[str, Any]]:
    names = ["height", "width", "channels"]
    features: dict[str, dict[str, Any]] = {}
    for camera in cameras:
        features[image_key(camera)] = {"dtype": dtype, "shape": (height, width, 3), "names": names}
        features[depth_key(camera)] = {
            "dtype": dtype,
            "shape": (height, width, 1),
            "names": names,
            "info": {"is_depth_map": True},
        }
    return features


def _common_features(cameras: Sequence[str]) -> dict[str, dict[str, Any]]:
    count = len(cameras)
    scalar_int = {"dtype": "int64", "shape": (1,), "names": None}
    return {
        INTRINSICS: {"dtype": "float32", "shape": (count, 3, 3), "names": None},
        EXTRINSICS: {"dtype": "float32", "shape": (count, 4, 4), "names": None},
        STATE: {"dtype": "float32", "shape": (STATE_DIM,), "names": list(STATE_NAMES)},
        VELOCITY: {"dtype": "float32", "shape": (VELOCITY_DIM,), "names": list(VELOCITY_NAMES)},
        ACTION: {"dtype": "float32", "shape": (ACTION_DIM,), "names": list(ACTION_NAMES)},
        INSTRUCTION: {"dtype": "string", "shape": (1,), "names": None},
        PREVIOUS_INSTRUCTION: {"dtype": "string", "shape": (1,), "names": None},
        STEP: {"dtype": "float32", "shape": (1,), "names": None},
        IS_KEYFRAME: {"dtype": "bool", "shape": (1,), "names": None},
        KEYFRAME_INDEX: dict(scalar_int),
        NEXT_KEYFRAME: dict(scalar_int),
        EPISODE_SEED: dict(scalar_int),
        EPISODE_VARIATION: dict(scalar_int),
        EPISODE_SEQUENCE: dict(scalar_int),
        **{key: {"dtype": "string", "shape": (1,), "names": None} for key in ORIGIN_COLUMNS},
    }


def demonstration_features(
    height: int = IMAGE_SIZE, width: int = IMAGE_SIZE, cameras: Sequence[str] = CAMERAS
) -> dict[str, dict[str, Any]]:
    """LeRobot features of a demonstrations dataset: dense frames, cameras stored as video."""
    return _image_features(cameras, height, width, "video") | _common_features(cameras)


def keystep_features(
    height: int = IMAGE_SIZE, width: int = IMAGE_SIZE, cameras: Sequence[str] = CAMERAS
) -> dict[str, dict[str, Any]]:
    """LeRobot features of a keysteps dataset: training samples, cameras stored as images for fast random access."""
    return _image_features(cameras, height, width, "image") | _common_features(cameras)
