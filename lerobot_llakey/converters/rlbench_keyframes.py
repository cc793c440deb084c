"""PerAct's own keyframes: where the gripper opens or closes, where the arm stands, and the last frame."""

from __future__ import annotations

import numpy as np

_STILL = 0.1
"""Radians a second below which every joint counts as standing."""
_PAUSE = 4
"""Frames after a stop within which no other one counts."""


def keypoints(gripper_open: np.ndarray, joint_velocities: np.ndarray) -> list[int]:
    """Keyframes of one RLBench episode, by the rule that PerAct, RVT and their data share.

    A frame is a keyframe if the gripper's state differs from that of the frame before; if all joints are slower than
    0.1 rad/s, no stop lies in the 4 frames before it and the gripper is the same from two frames before to one after;
    or if it is the last. Of two keyframes in a row at the end only the last one stays.

    Source: Shridhar et al., "Perceiver-Actor" (CoRL 2022), section 3.2, after James and Davison, "Q-attention" (RA-L
    2022). As there, the frames before the first are those at the end: a stop at frame 0 or 1 needs the gripper to be
    as it is in the end.

    Args:
        gripper_open: (T,) bool.
        joint_velocities: (T, J) radians a second.

    Returns:
        Increasing frames above 0, the last one T - 1.
    """
    length = len(gripper_open)
    slow = np.abs(joint_velocities).max(axis=1, initial=0.0) <= _STILL
    found: list[int] = []
    pause = 0
    for frame in range(length):
        same = frame < length - 2 and bool(
            gripper_open[frame] == gripper_open[frame + 1] == gripper_open[frame - 1] == gripper_open[frame - 2]
        )
        stopped = pause <= 0 and bool(slow[frame]) and same
        pause = _PAUSE if stopped else pause - 1
        changed = frame > 0 and gripper_open[frame] != gripper_open[frame - 1]
        if frame and (changed or stopped or frame == length - 1):
            found.append(frame)
    if len(found) > 1 and found[-1] - 1 == found[-2]:
        found.pop(-2)
    return found
