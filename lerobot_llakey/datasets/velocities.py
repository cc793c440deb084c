"""Velocities of recordings that hold positions alone."""

from __future__ import annotations

import numpy as np

from lerobot_llakey import schema


def estimate_velocities(states: np.ndarray, fps: float) -> np.ndarray:
    """Velocities (T, 8) float32 of the data contract from an episode's states (T, 15), by central differences.

    Args:
        states: of at least two frames.
        fps: frames a second.
    """
    moving = np.concatenate((states[:, schema.JOINTS], states[:, [schema.GRIPPER]]), axis=1)
    return np.gradient(moving.astype(np.float64), 1 / fps, axis=0).astype(np.float32)
