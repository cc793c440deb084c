"""Made-up motions that never rest: straight moves whose ends run into one another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.keyframes.motion import Motion


def moving(
    corners: Sequence[Sequence[float]],
    yaws: Sequence[float] | None = None,
    *,
    frames: int = 20,
    fps: float = 20.0,
    noise: float = 0.001,
    grips: Sequence[tuple[int, float]] = (),
    commanded: bool = False,
    slow: bool = False,
) -> Motion:
    """A hand that goes from corner to corner, ``frames`` frames a move.

    Args:
        corners: places in metres.
        yaws: radians at each corner.
        frames: of each move.
        fps: frames a second.
        noise: metres and radians.
        grips: frames at which the gripper begins to move, and to which opening, within four frames.
        commanded: whether its command is recorded.
        slow: whether the hand slows down at corners without stopping, else it keeps its speed.
    """
    rng = np.random.default_rng(0)
    share = np.arange(frames * (len(corners) - 1) + 1) / frames
    if slow:
        share = share - 0.8 * np.sin(2 * np.pi * share) / (2 * np.pi)
    places = np.column_stack([np.interp(share, range(len(corners)), axis) for axis in np.transpose(corners)])
    angles = np.zeros(len(share)) if yaws is None else np.interp(share, range(len(corners)), yaws)
    turns = Rotation.from_euler("z", angles[:, None]) * Rotation.from_rotvec(rng.normal(0, noise, (len(share), 3)))
    openings, commands = np.ones(len(share)), np.ones(len(share))
    for frame, opening in grips:
        openings[frame:] = opening
        openings[frame : frame + 4] = np.linspace(openings[frame - 1], opening, 5)[1:]
        commands[frame:] = opening
    poses = np.column_stack((places + rng.normal(0, noise, places.shape), turns.as_quat()))
    return Motion(poses, openings, fps, None, commands > 0.5 if commanded else None)
