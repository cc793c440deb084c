"""Velocities of recordings that hold positions alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lerobot_llakey.hand import further_columns, hand_columns


def velocity_columns(state_names: Sequence[str]) -> tuple[list[str], list[int]]:
    """Names of the contract's velocities for a state of these names, and the places of what they are the rates of.

    Args:
        state_names: in the contract's terms: a pose, an opening or none, any further numbers.
    """
    hand, further = hand_columns(state_names), further_columns(state_names)
    names = [f"{state_names[place].removesuffix('.pos')}_velocity" for place in further]
    gripper = hand[7:]
    return [*names, *("gripper_velocity" for _ in gripper)], [*further, *gripper]


def estimate_velocities(values: np.ndarray, fps: float) -> np.ndarray:
    """Velocities (T, M) float32 of an episode's numbers (T, M).

    Each is the smaller of the changes before and after its frame, and 0 where these disagree in sign: so the frame at
    which a motion begins or ends counts as standing, as it does for keyframe discovery.

    Args:
        values: of at least two frames.
        fps: frames a second.
    """
    changes = np.diff(values.astype(np.float64), axis=0) * fps  # (T - 1, M)
    before, after = np.concatenate((changes[:1], changes)), np.concatenate((changes, changes[-1:]))
    smaller = np.where(np.abs(before) < np.abs(after), before, after)
    return np.where(before * after > 0, smaller, 0.0).astype(np.float32)
