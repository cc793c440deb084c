"""The data contract: every feature name, shape and unit that datasets, policies and environments share.

Nothing else in the package spells a feature name. Conventions: metres and radians in the robot's base frame,
quaternions xyzw of either sign and without jumps within an episode, depth as metric z-depth in float32 millimetres,
cameras in OpenCV frames.

LeRobot stacks every column under ``observation.`` over time for policies that look back, which texts cannot bear, so
texts stand in columns without that prefix. LeRobot's processors drop those; policies look them up by ``index``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from lerobot_llakey.errors import LlakeyError

CAMERAS: tuple[str, ...] = ("front", "left_shoulder", "right_shoulder", "wrist")
"""The simulator's cameras. Other datasets have others: :func:`cameras_of` lists them."""

STATE = "observation.state"
ACTION = "action"
INDEX = "index"
"""LeRobot's own column: a frame's place in the whole dataset."""
INSTRUCTION = "instruction"
"""The instruction that leads to the next keyframe, a text."""
PREVIOUS_INSTRUCTION = "previous_instruction"
"""The instruction last commanded when the frame was taken: the finished one at a keyframe, else the current one."""
TEXTS = (INSTRUCTION, PREVIOUS_INSTRUCTION)
GRAMMAR_INFO = "grammar"
"""Where the ``info`` of the instruction feature keeps the texts' grammar."""
STEP = "observation.step"
"""Number of keyframe actions taken before the frame, float32 (1,): the timestep that RVT is given."""
ORACLE_INSTRUCTION = "observation.oracle_instruction"
"""The expert's instruction from the present state: a list of texts once LeRobot's environment processors have run."""
VELOCITY = "observation.velocity"
"""How fast each further number of the state changes (radians a second for joints), then, where the robot has a gripper,
how fast it opens (opening, 0..1, a second); float32."""
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
TASK = "task"

POSE_NAMES: tuple[str, ...] = ("x", "y", "z", "qx", "qy", "qz", "qw")
"""A pose: metres, unit quaternion."""
HAND_NAMES: tuple[str, ...] = (*POSE_NAMES, "gripper_opening")
"""What of a state policies read, found in any order by the feature's names: see :mod:`lerobot_llakey.hand`."""
INTRINSICS_NAMES: tuple[str, ...] = ("fx", "fy", "cx", "cy")
"""A pinhole camera's focal lengths and principal point, in pixels of its recorded image."""
SIM_STATE_NAMES: tuple[str, ...] = (*HAND_NAMES, *(f"joint_{i}" for i in range(1, 8)))
"""The simulator's state. Other robots have other further numbers, or none."""
GRIPPER_VELOCITY = "gripper_velocity"
SIM_VELOCITY_NAMES: tuple[str, ...] = (*(f"joint_{i}_velocity" for i in range(1, 8)), GRIPPER_VELOCITY)
ACTION_NAMES: tuple[str, ...] = ("x", "y", "z", "qx", "qy", "qz", "qw", "gripper_open", "ignore_collision")
HAND_DIM = len(HAND_NAMES)
ACTION_DIM = len(ACTION_NAMES)

POSITION = slice(0, 3)
QUATERNION = slice(3, 7)
GRIPPER = 7
"""Column of the gripper in both a hand (opening, 0..1) and an action (1 = open)."""
IGNORE_COLLISION = 8
"""Column of the collision flag in the action: 1 = the planner may touch things."""

IMAGE_SIZE = 128
DEPTH_RANGE_METRES = (0.0, 4.095)
"""Range of the depth videos: their 12 bits hold every whole millimetre from 0, which is not measured, to 4.095 m.

The cameras' near plane and all that a policy acts on lie within it; what is farther away counts as 4.095 m.
"""

Workspace = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
WORKSPACE: Workspace = ((0.0, 1.0), (-0.5, 0.5), (-0.05, 0.95))
"""The simulator's bounds (metres) of x, y and z in which keyframes and point clouds live."""

UNIT_TOLERANCE = 0.02
"""By how much a quaternion's length may differ from 1; recorded ones are rounded."""
FARTHEST = 10.0
"""Metres from the base beyond which no arm reaches: such a position is in another unit."""

TEXT_LENGTH = 160
"""Characters of the longest instruction."""

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


def intrinsics_key(camera: str) -> str:
    """Feature name of a camera's intrinsics (4,), see INTRINSICS_NAMES."""
    return f"observation.camera_intrinsics.{camera}"


def extrinsics_key(camera: str) -> str:
    """Feature name of a camera's pose (7,) in the base frame, see POSE_NAMES: camera-to-base, OpenCV axes."""
    return f"observation.camera_extrinsics.{camera}"


def cameras_of(features: Iterable[str], depth: bool = False) -> tuple[str, ...]:
    """Names of the cameras among feature names, in their order.

    Args:
        features: names, such as the keys of a dataset's ``features`` or a policy's ``input_features``.
        depth: only those with depth and calibration, which can be fused into a point cloud.
    """
    names = list(features)
    prefix = image_key("")
    depths = {name for name in names if name.startswith(prefix) and name.endswith("_depth")}
    cameras = tuple(name.removeprefix(prefix) for name in names if name.startswith(prefix) and name not in depths)
    if not depth:
        return cameras
    return tuple(
        camera
        for camera in cameras
        if {depth_key(camera), intrinsics_key(camera), extrinsics_key(camera)} <= set(names)
    )


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


Size = tuple[int, int]
"""Height and width of an image in pixels."""


def _camera_features(sizes: Mapping[str, Size], dtype: str) -> dict[str, dict[str, Any]]:
    axes = ["height", "width", "channels"]
    features: dict[str, dict[str, Any]] = {}
    for camera, (height, width) in sizes.items():
        features[image_key(camera)] = {"dtype": dtype, "shape": (height, width, 3), "names": axes}
        features[depth_key(camera)] = {
            "dtype": dtype,
            "shape": (height, width, 1),
            "names": axes,
            "info": {"is_depth_map": True},
        }
        features[intrinsics_key(camera)] = vector(INTRINSICS_NAMES)
        features[extrinsics_key(camera)] = vector(POSE_NAMES)
    return features


def vector(names: Sequence[str]) -> dict[str, Any]:
    """LeRobot's description of a float32 column of named numbers."""
    return {"dtype": "float32", "shape": (len(names),), "names": list(names)}


def label_features(grammar: Any = "basic") -> dict[str, dict[str, Any]]:
    """LeRobot features of what :mod:`lerobot_llakey.labels` makes of a recording, and of where an episode came from.

    Args:
        grammar: of the instructions, as ``Grammar.to_data`` gives it.
    """
    scalar_int = {"dtype": "int64", "shape": (1,), "names": None}
    text = {"dtype": "string", "shape": (1,), "names": None}
    return {
        ACTION: vector(ACTION_NAMES),
        INSTRUCTION: {**text, "info": {GRAMMAR_INFO: grammar}},
        PREVIOUS_INSTRUCTION: dict(text),
        STEP: {"dtype": "float32", "shape": (1,), "names": None},
        IS_KEYFRAME: {"dtype": "bool", "shape": (1,), "names": None},
        KEYFRAME_INDEX: dict(scalar_int),
        NEXT_KEYFRAME: dict(scalar_int),
        EPISODE_SEED: dict(scalar_int),
        EPISODE_VARIATION: dict(scalar_int),
        EPISODE_SEQUENCE: dict(scalar_int),
        **{key: dict(text) for key in ORIGIN_COLUMNS},
    }


def dataset_features(
    cameras: Mapping[str, Size] | None = None,
    state_names: Sequence[str] = SIM_STATE_NAMES,
    velocity_names: Sequence[str] = SIM_VELOCITY_NAMES,
    *,
    dtype: str = "video",
) -> dict[str, dict[str, Any]]:
    """LeRobot features of a dataset.

    Args:
        cameras: height and width in pixels of each RGB-D camera; the simulator's where None.
        state_names: of the state's numbers, those of HAND_NAMES among them.
        velocity_names: of the velocity's numbers.
        dtype: "video" for demonstrations (dense frames), "image" for keysteps, whose samples are read at random.
    """
    sizes = dict.fromkeys(CAMERAS, (IMAGE_SIZE, IMAGE_SIZE)) if cameras is None else cameras
    numbers = {STATE: vector(state_names), VELOCITY: vector(velocity_names)}
    return _camera_features(sizes, dtype) | numbers | label_features()
