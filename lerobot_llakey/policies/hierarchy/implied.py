"""Conditions hidden in the words of an instruction, imposed on the action (algorithm 1 of the paper, lines 6 to 8)."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey import schema


def set_gripper(action: np.ndarray, implied: bool | None) -> np.ndarray:
    """The action (9,) with the gripper that the words ask for: True open, False closed, None as it is."""
    changed = np.array(action, dtype=np.float64)
    if implied is not None:
        changed[schema.GRIPPER] = float(implied)
    return changed


def about_tool_axis(action: np.ndarray, state: np.ndarray) -> np.ndarray:
    """The action (9,) with all motion taken out but that about and along the hand's own z axis: what a screw does.

    Args:
        action: with a quaternion of non-zero length.
        state: (15,) the present state.
    """
    changed = np.array(action, dtype=np.float64)
    present = Rotation.from_quat(state[schema.QUATERNION])
    _, _, z, w = (present.inv() * Rotation.from_quat(changed[schema.QUATERNION])).as_quat()
    # The twist of the swing-twist decomposition; half a turn about another axis has none.
    twist = Rotation.from_quat([0.0, 0.0, z, w]) if np.hypot(z, w) > 1e-6 else Rotation.identity()
    axis = present.as_matrix()[:, 2]
    position = np.asarray(state[schema.POSITION], dtype=np.float64)
    changed[schema.POSITION] = position + axis * (axis @ (changed[schema.POSITION] - position))
    changed[schema.QUATERNION] = (present * twist).as_quat()
    return changed


def straight_up(action: np.ndarray, state: np.ndarray) -> np.ndarray:
    """The action (9,) with the hand where it is or right above, at the height asked for if that is above."""
    changed = np.array(action, dtype=np.float64)
    x, y, z = np.asarray(state[schema.POSITION], dtype=np.float64)
    changed[schema.POSITION] = x, y, max(z, changed[2])
    return changed
