"""Whether recorded states, once they are in the contract's terms, are in its units, as far as names and values tell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.hand import hand_columns, joint_columns

_MOST_TURNED = 4 * np.pi
"""Radians beyond which no joint turns; degrees get there within a few frames."""
_FASTEST_JOINT, _USUAL = 8.0, 75
"""Radians a second that three quarters of an arm's motion stay below, percent: sensors that jump are left to others."""
_OFF_UNIT = 0.05
_PLAY = 0.05
"""How far beyond 0..1 an opening may lie."""
_METRES_OPEN, _MOVED = 0.13, 0.005
"""A gripper that moves, and never opens farther than a hand's width in metres, was not recorded as a share."""


def check_states(states: np.ndarray, state_names: Sequence[str], episodes: np.ndarray, fps: float) -> None:
    """Check that states are finite and in metres, radians, unit quaternions and openings from 0 to 1.

    Args:
        states: (T, N) of all episodes, in the contract's terms.
        state_names: of their numbers.
        episodes: (T,) index of each row's episode.
        fps: frames a second.

    Raises:
        LlakeyError: if they look like degrees, millimetres, percent, metres of a gripper's opening, or no rotation.
    """
    hand = states[:, list(hand_columns(state_names))]
    position, joints = hand[:, schema.POSITION], states[:, joint_columns(state_names)]
    norm = np.linalg.norm(hand[:, schema.QUATERNION], axis=1)
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
        "unit quaternions of the hand",
        "check which numbers are the rotation, by --state_names and --rotation",
        "norm ",
    )
    _refuse(
        np.abs(joints) > _MOST_TURNED,
        joints,
        episodes,
        "joint angles in radians",
        "multiply by pi / 180 if these are degrees, or name them otherwise by --state_names",
    )
    within = np.diff(episodes, prepend=episodes[:1] - 1) == 0
    speeds = np.abs(np.diff(joints, axis=0, prepend=joints[:1])) * fps * within[:, None]
    moving = speeds[speeds > np.deg2rad(1)]
    if moving.size and np.percentile(moving, _USUAL) > _FASTEST_JOINT:
        raise LlakeyError(
            f"Expected joint angles in radians in {schema.STATE}, got joints that turn by "
            f"{np.percentile(moving, _USUAL):.3g} a second, as in degrees; multiply by pi / 180, or name them "
            "otherwise by --state_names."
        )
    gripper = hand[:, schema.GRIPPER :]
    _refuse(
        (gripper < -_PLAY) | (gripper > 1 + _PLAY),
        gripper,
        episodes,
        "the gripper's opening from 0, closed, to 1, open",
        "give --gripper_range=[closed,open]: [0,100] for percent, [0,255] for 8 bits",
    )
    if gripper.size and np.ptp(gripper) > _MOVED and gripper.max() < _METRES_OPEN:
        raise LlakeyError(
            f"Expected the gripper's opening from 0, closed, to 1, open, got at most {gripper.max():.3g} in "
            f"{len(np.unique(episodes))} episodes, as in metres; give --gripper_range=[0,{gripper.max():.2g}] or the "
            "width to which it opens."
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
