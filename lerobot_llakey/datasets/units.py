"""Whether recorded states are in the contract's units and order, as far as names and values tell."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.metadata import names_of
from lerobot_llakey.errors import LlakeyError

_MOST_TURNED = 2 * np.pi
_OFF_UNIT = 0.05
_PLAY = 0.05
"""How far beyond 0..1 an opening may lie."""
_METRES_OPEN, _MOVED = 0.13, 0.005
"""A gripper that moves, and never opens farther than a hand's width in metres, was not recorded as a share."""


def check_names(feature: Mapping[str, Any], key: str = schema.STATE) -> None:
    """Check that names of a state's columns, where there are any of the contract's, stand in its order.

    Args:
        feature: LeRobot's description of the state.
        key: its name.

    Raises:
        LlakeyError: if they do not, as where a quaternion was recorded as qw, qx, qy, qz.
    """
    given = names_of(feature)
    moved = [
        name
        for place, name in enumerate(given)
        if name in schema.STATE_NAMES[:8] and schema.STATE_NAMES.index(name) != place
    ]
    if moved:
        raise LlakeyError(
            f"Expected the columns of {key} in the order {', '.join(schema.STATE_NAMES)}, got {', '.join(given)}; put "
            f"{', '.join(moved)} in its place and record anew, or correct the names if they are wrong."
        )


def check_states(states: np.ndarray, episodes: np.ndarray) -> None:
    """Check that states are finite and in metres, radians, unit quaternions and openings from 0 to 1.

    Args:
        states: (T, 15) of all episodes.
        episodes: (T,) index of each row's episode.

    Raises:
        LlakeyError: if they look like degrees, millimetres, percent, metres of a gripper's opening, or no rotation.
    """
    position, joints = states[:, schema.POSITION], states[:, schema.JOINTS]
    gripper, norm = states[:, schema.GRIPPER], np.linalg.norm(states[:, schema.QUATERNION], axis=1)
    _refuse(~np.isfinite(states), states, episodes, "finite numbers", "drop the episode or correct the recording")
    _refuse(
        np.abs(position) > schema.FARTHEST,
        position,
        episodes,
        "the hand's position in metres",
        "divide by 1000 if these are millimetres, by 100 if centimetres",
    )
    _refuse(
        np.abs(norm - 1) > _OFF_UNIT,
        norm,
        episodes,
        "unit quaternions (qx, qy, qz, qw) of the hand",
        "record the rotation as a quaternion of norm 1",
        "norm ",
    )
    _refuse(
        np.abs(joints) > _MOST_TURNED,
        joints,
        episodes,
        "joint angles in radians",
        "multiply by pi / 180 if these are degrees",
    )
    _refuse(
        (gripper < -_PLAY) | (gripper > 1 + _PLAY),
        gripper,
        episodes,
        "the gripper's opening from 0, closed, to 1, open",
        "divide by its largest value: 100 for percent, 255 for 8 bits",
    )
    if np.ptp(gripper) > _MOVED and gripper.max() < _METRES_OPEN:
        raise LlakeyError(
            f"Expected the gripper's opening from 0, closed, to 1, open, got at most {gripper.max():.3g} in "
            f"{len(np.unique(episodes))} episodes, as in metres; divide by its width when open."
        )


def _refuse(
    wrong: np.ndarray, values: np.ndarray, episodes: np.ndarray, wanted: str, advice: str, what: str = ""
) -> None:
    if not wrong.any():
        return
    row = int(np.argwhere(wrong)[0][0])
    frame = row - int(np.flatnonzero(episodes == episodes[row])[0])
    came = values[wrong].flat[0]
    raise LlakeyError(
        f"Expected {wanted} in {schema.STATE}, got {what}{came:.4g} in episode {int(episodes[row])}, frame {frame}; "
        f"{advice}."
    )
