"""The rule ``rest``: a keyframe is where the robot has come to rest after moving.

The paper (section III-A) follows PerAct: the gripper's state changed, all joint velocities are near zero, or it is the
last frame. Here these are one idea, the *rest*: the robot moves, then neither arm nor gripper moves for a while, and
the first frame of that rest is the keyframe. An arm that stops, closes its gripper at once and then rests thus gives
one keyframe, after the closing.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from lerobot_llakey.bounds import require_number
from lerobot_llakey.errors import LlakeyError

_ARRIVED_ARM = 0.05
_ARRIVED_GRIPPER = 1 / 6
"""How near the resting configuration counts as arrived when the sensors are noiseless, in shares of the tolerances."""
_LONGEST_REST, _LARGEST_TOLERANCE = 60.0, 1.0
"""Seconds; radians, and share of the gripper's travel: beyond these no motion would ever be found."""


def pose_numbers(poses: npt.ArrayLike, position_tolerance: float, rotation_tolerance: float) -> np.ndarray:
    """What stands for the joints of an arm whose hand's pose alone is known: (T, 7), to rest within 1.

    Positions count in units of their tolerance. So do quaternions of continuous sign, doubled: the distance between
    two of them is then the angle between the rotations in radians, as long as it is small, and nothing wraps around.
    Give the numbers to :func:`discover_keyframes` with ``arm_tolerance=1``.

    Args:
        poses: (T, 7) or more, metres and quaternions without jumps.
        position_tolerance: metres that a resting hand may stray.
        rotation_tolerance: radians that it may turn.

    Raises:
        LlakeyError: if a tolerance makes no sense.
    """
    require_number("position_tolerance", position_tolerance, 0, _LARGEST_TOLERANCE, open="low")
    require_number("rotation_tolerance", rotation_tolerance, 0, _LARGEST_TOLERANCE, open="low")
    values = np.asarray(poses, dtype=np.float64)
    return np.concatenate((values[:, :3] / position_tolerance, 2 * values[:, 3:7] / rotation_tolerance), axis=1)


def discover_keyframes(
    joint_positions: npt.ArrayLike,
    gripper_opening: npt.ArrayLike,
    fps: float,
    *,
    min_rest: float = 0.2,
    arm_tolerance: float = 0.01,
    gripper_tolerance: float = 0.03,
) -> list[int]:
    """Frames at which the robot has come to rest after moving.

    Rules:
        - A rest lasts at least ``min_rest`` and three frames, and within every window of that length no joint strays by
          more than ``arm_tolerance`` and the opening by no more than ``gripper_tolerance``. Shorter stops are part of
          the motion.
        - Each rest that follows motion gives one keyframe: its first frame at which arm and gripper have arrived, that
          is, lie at the rest's median configuration to within sensor noise (estimated from the rests themselves). A
          rest that lies within a quarter of the tolerances for less than ``min_rest`` is only the slow end of a move.
        - The last frame is always a keyframe, and stands for the rest it lies in: the final rest gives no other one.
        - Frame 0, and the rest it lies in, is never a keyframe.

    With the defaults motion is what exceeds about 0.05 rad/s. Joint noise up to 0.5 mrad (standard deviation) at 10 fps
    neither adds nor hides a keyframe, but may shift it by a frame; 1 mrad miscounts 3 of 1,000 made-up episodes.

    Args:
        joint_positions: (T, J) radians, J of any number; of a hand alone, see :func:`pose_numbers`.
        gripper_opening: (T,) in 0..1, a constant without a gripper.
        fps: frames a second.
        min_rest: seconds; keep it below the shortest real rest.
        arm_tolerance: radians that a resting joint may stray.
        gripper_tolerance: share of its travel that a resting gripper may stray.

    Returns:
        Increasing frame indices; the last one is T - 1.

    Raises:
        LlakeyError: if the shapes do not fit, a value is not finite, there are fewer than 2 frames or a setting makes
            no sense.
    """
    arm = np.asarray(joint_positions, dtype=np.float64)
    gripper = np.asarray(gripper_opening, dtype=np.float64)
    if arm.ndim != 2 or not arm.size or gripper.shape != arm.shape[:1] or len(arm) < 2:
        raise LlakeyError(
            f"Expected joint positions (T, J) and gripper openings (T,) with T >= 2, got {arm.shape} and "
            f"{gripper.shape}; pass one whole episode."
        )
    if not (np.isfinite(arm).all() and np.isfinite(gripper).all()):
        raise LlakeyError("Expected finite joint positions and gripper openings, got NaN or inf; drop the episode.")
    require_number("fps", fps, 0, open="low")
    require_number("min_rest", min_rest, 0, _LONGEST_REST, open="low")
    require_number("arm_tolerance", arm_tolerance, 0, _LARGEST_TOLERANCE, open="low")
    require_number("gripper_tolerance", gripper_tolerance, 0, _LARGEST_TOLERANCE, open="low")
    window = max(2, round(min_rest * fps))  # one still pair of frames is no rest: hands hesitate
    rests = _rests(arm, gripper, window, arm_tolerance, gripper_tolerance)
    noise = _noise(rests, arm), _noise(rests, gripper[:, None])
    last = len(arm) - 1
    keyframes = {last}
    for rest in rests:
        strays = _strays(rest, arm), _strays(rest, gripper[:, None])
        settled = _within(strays, (arm_tolerance / 4, gripper_tolerance / 4), noise)
        if rest.start > 0 and rest.stop <= last and settled.sum() > window:
            arrived = _within(strays, (arm_tolerance * _ARRIVED_ARM, gripper_tolerance * _ARRIVED_GRIPPER), noise)
            keyframes.add(rest.start + int(np.argmax(arrived)))
    return sorted(keyframes)


def _rests(
    arm: np.ndarray, gripper: np.ndarray, window: int, arm_tolerance: float, gripper_tolerance: float
) -> list[range]:
    """Frames of each rest, in order; the first may start at frame 0 and the last may hold the last frame."""
    scaled = np.concatenate((arm / arm_tolerance, gripper[:, None] / gripper_tolerance), axis=1)
    rests: list[range] = []
    previous = -2
    for start in range(len(scaled) - window):
        if np.ptp(scaled[start : start + window + 1], axis=0).max() > 1.0:
            continue
        # A run of quiet windows is one rest; so are two runs with one stray frame between them.
        joined = start == previous + 1
        if joined or (rests and start <= rests[-1].stop + 1 and _same(scaled, rests[-1], start, window)):
            rests[-1] = range(rests[-1].start, start + window + 1)
        else:
            rests.append(range(start, start + window + 1))
        previous = start
    if rests:
        tail = np.arange(rests[-1].stop, len(scaled))
        centre = np.median(scaled[rests[-1]], axis=0)
        if len(tail) <= window and np.all(np.abs(scaled[tail] - centre).max(axis=1, initial=0.0) <= 1.0):
            rests[-1] = range(rests[-1].start, len(scaled))
    return rests


def _same(scaled: np.ndarray, rest: range, start: int, window: int) -> bool:
    """Whether the quiet window at ``start`` holds the same configuration as the rest before it."""
    later = np.median(scaled[start : start + window + 1], axis=0)
    return bool(np.abs(np.median(scaled[rest], axis=0) - later).max() <= 1.0)


def _strays(rest: range, values: np.ndarray) -> np.ndarray:
    """Distances (frames, J) from the rest's median configuration."""
    return np.abs(values[rest] - np.median(values[rest], axis=0))


def _noise(rests: list[range], values: np.ndarray) -> float:
    """Standard deviation of the sensors' noise, from how far all rests stray."""
    return 1.4826 * float(np.median(np.concatenate([_strays(rest, values) for rest in rests]))) if rests else 0.0


def _within(strays: tuple[np.ndarray, ...], tolerances: tuple[float, ...], noise: tuple[float, ...]) -> np.ndarray:
    """For each frame of a rest, whether arm and gripper are as near to where they stay as noise allows."""
    limits = zip(strays, tolerances, noise, strict=True)
    return np.all([stray.max(axis=1) <= tolerance + 4.0 * sigma for stray, tolerance, sigma in limits], axis=0)
