"""What the hand did in a segment, in words: from proprioception, which knows the motion better than pictures do."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey import schema

_MOVED, _TURNED = 0.01, 10.0
"""Metres and degrees below which a motion goes without saying."""
_UPRIGHT = 0.9
"""Cosine of the angle to the vertical up to which an axis counts as vertical."""
_WAYS = (("forward", "back"), ("left", "right"), ("up", "down"))
"""Along the base's x, y and z axis, and against it."""


def motion_words(before: np.ndarray, after: np.ndarray, opened: tuple[bool, bool] | None) -> str:
    """A segment's motion in words, such as "moved up 12 cm and left 3 cm, turned 90 degrees, gripper closed".

    Args:
        before: (7,) the hand's pose where the segment begins, in the base's frame: x ahead, y to the left, z up.
        after: (7,) where it ends.
        opened: whether the gripper is open at either end; None without a gripper.
    """
    moved = after[schema.POSITION] - before[schema.POSITION]
    ways = [
        (abs(distance), f"{names[int(distance < 0)]} {100 * abs(distance):.0f} cm")
        for distance, names in zip(moved, _WAYS, strict=True)
        if abs(distance) >= _MOVED
    ]
    parts = [f"moved {' and '.join(words for _, words in sorted(ways, reverse=True))}"] if ways else []
    first, last = (Rotation.from_quat(pose[schema.QUATERNION]) for pose in (before, after))
    turn = (last * first.inv()).as_rotvec(degrees=True)
    angle = float(np.linalg.norm(turn))
    if angle >= _TURNED:
        upright = abs(turn[2]) >= _UPRIGHT * angle
        way = ("counterclockwise" if turn[2] > 0 else "clockwise") + " as seen from above" if upright else "tilting"
        parts.append(f"turned {angle:.0f} degrees, {way}")
    parts = parts or ["stayed where it was"]
    if opened is not None:
        was, is_ = opened
        change = "opened" if is_ else "closed"
        parts.append(f"gripper {change}" if was != is_ else f"gripper stayed {'open' if is_ else 'closed'}")
    return ", ".join(parts)
