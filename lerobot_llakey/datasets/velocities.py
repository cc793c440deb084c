"""Velocities of recordings that hold positions alone."""

from __future__ import annotations

import numpy as np

from lerobot_llakey import schema


def estimate_velocities(states: np.ndarray, fps: float) -> np.ndarray:
    """Velocities (T, 8) float32 of the data contract from an episode's states (T, 15).

    Each is the smaller of the changes before and after its frame, and 0 where these disagree in sign: so the frame at
    which a motion begins or ends counts as standing, as it does for keyframe discovery.

    Args:
        states: of at least two frames.
        fps: frames a second.
    """
    values = np.concatenate((states[:, schema.JOINTS], states[:, [schema.GRIPPER]]), axis=1).astype(np.float64)
    changes = np.diff(values, axis=0) * fps  # (T - 1, 8)
    before, after = np.concatenate((changes[:1], changes)), np.concatenate((changes, changes[-1:]))
    smaller = np.where(np.abs(before) < np.abs(after), before, after)
    return np.where(before * after > 0, smaller, 0.0).astype(np.float32)
