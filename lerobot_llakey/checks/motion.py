"""Hands that move as hands do: steadily, without a jump of a quaternion's sign, and at all."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import Columns
from lerobot_llakey.checks.finding import Finding, told
from lerobot_llakey.checks.order import is_visited

STILL, STILL_TURN = 0.005, float(np.deg2rad(3))
"""Metres and radians within which a hand counts as being at one pose."""
_STILL_GRIPPER = 0.05
_FLIPPED = -0.9
"""Product of neighbouring quaternions below which the sign jumped: the hand itself turned by less than 52 degrees."""
_SPIKE, _SPIKE_TURN = 0.05, float(np.deg2rad(30))
"""Metres and radians by which a single frame may stand out from both its neighbours."""
_LEAP, _LEAP_TURN = 0.5, float(np.deg2rad(120))
"""Metres and radians between two frames that no hand moves by."""


def check_motion(columns: Columns, dense: bool) -> Iterator[Finding]:
    """Warn of quaternions whose sign jumps, of frames that stand out, and of episodes in which nothing moves.

    Args:
        columns: of a file.
        dense: whether it holds whole recordings, whose neighbouring rows are neighbours in time.
    """
    hand = columns.hand
    if hand is None or not len(columns):
        return
    same = np.ones(len(columns), dtype=bool)
    same[[rows.start for rows in columns.episodes()]] = False
    for key, values in ((schema.STATE, hand), (schema.ACTION, columns.values.get(schema.ACTION))):
        if values is None or values.ndim != 2 or values.shape[1] < schema.HAND_DIM:
            continue
        turns = values[:, schema.QUATERNION].astype(np.float64)
        flipped = same & (np.concatenate(([1.0], (turns[1:] * turns[:-1]).sum(axis=1))) < _FLIPPED)
        if flipped.any():
            expected = "quaternions whose sign does not jump within an episode, as other policies regress them,"
            got, advice = told(turns[flipped][0]), "negate the quaternions from there on"
            yield Finding(key, expected, got, advice, columns.place(flipped), certain=False)
    if dense:
        yield from _jumps(columns, hand, same)
    yield from _still(columns, hand)


def moved(poses: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Metres and radians between poses (N, 7 or more) of either sign."""
    apart = np.linalg.norm(poses[:, schema.POSITION].astype(float) - others[:, schema.POSITION], axis=1)
    product = np.abs((poses[:, schema.QUATERNION].astype(float) * others[:, schema.QUATERNION]).sum(axis=1))
    return apart, 2 * np.arccos(np.clip(product, 0, 1))


def _jumps(columns: Columns, hand: np.ndarray, same: np.ndarray) -> Iterator[Finding]:
    """Frames that stand out from both neighbours, and neighbours that no hand moves between."""
    step, turn = moved(hand[1:], hand[:-1])
    leap = np.zeros(len(hand), dtype=bool)
    leap[1:] = same[1:] & ((step > _LEAP) | (turn > _LEAP_TURN))
    across, around = moved(hand[2:], hand[:-2])
    inner = same[1:-1] & same[2:]
    out = (np.minimum(step[1:], step[:-1]) > _SPIKE) & (across < np.minimum(step[1:], step[:-1]) / 2)
    out |= (np.minimum(turn[1:], turn[:-1]) > _SPIKE_TURN) & (around < np.minimum(turn[1:], turn[:-1]) / 2)
    leap[1:-1] |= inner & out
    if leap.any():
        row = int(np.flatnonzero(leap)[0])
        got = f"{100 * step[row - 1]:.0f} cm and {np.rad2deg(turn[row - 1]):.0f} degrees between two frames"
        advice = "drop the frame or the episode, and check the recording"
        yield Finding(schema.STATE, "a hand that moves steadily", got, advice, columns.place(leap), certain=False)


def _still(columns: Columns, hand: np.ndarray) -> Iterator[Finding]:
    """Episodes of several frames in which neither hand nor gripper moves teach nothing."""
    episodes = [rows for rows in columns.episodes() if rows.stop - rows.start > 1 and not is_visited(columns, rows)]
    wrong, count = np.zeros(len(columns), dtype=bool), 0
    for rows in episodes:
        part = hand[rows]
        if np.ptp(part[:, schema.GRIPPER]) > _STILL_GRIPPER or (np.ptp(part[:, :3], axis=0) > STILL).any():
            continue
        _, turn = moved(part, np.broadcast_to(part[:1], part.shape))
        if turn.max() <= STILL_TURN:
            wrong[rows.start], count = True, count + 1
    if count:
        got, advice = f"{count} of {len(episodes)} without any motion", "drop these episodes, or record the hand's pose"
        certain = count > len(episodes) / 2
        yield Finding(schema.STATE, "episodes in which the hand moves", got, advice, columns.place(wrong), certain)
