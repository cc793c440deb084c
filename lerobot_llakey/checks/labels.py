"""Actions that are what the hand reached at the next keyframe, as the data contract has it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import Columns
from lerobot_llakey.checks.finding import Finding, Place
from lerobot_llakey.checks.order import is_visited

_NEAR = 0.02
"""Metres between an action and the hand at its keyframe that count as the same."""
_ALIKE = float(np.cos(np.deg2rad(10) / 2))
"""Product of quaternions that are ten degrees apart."""
_FEW = 3
"""Pairs of an action and its keyframe below which nothing is said."""
_WXYZ = [3, 0, 1, 2]
_METRES = 0.12
"""Openings in metres stay below this."""


def check_labels(columns: Columns, dense: bool) -> Iterator[Finding]:
    """Compare actions with the states at their keyframes, where the columns hold both.

    Disturbed segments lead elsewhere than planned and states that a policy visited were labelled by an expert, so a
    dataset is refused only where most of its actions disagree.

    Args:
        columns: of a file.
        dense: whether it holds whole recordings, in which the next keyframe is a row.
    """
    if columns.hand is None or not columns.has(
        schema.ACTION, schema.KEYFRAME_INDEX, schema.NEXT_KEYFRAME, schema.IS_KEYFRAME
    ):
        return
    start, end = _pairs(columns, dense)
    if len(start) < _FEW:
        return
    action, state = columns[schema.ACTION][start].astype(float), columns.hand[end].astype(float)
    marks = np.zeros(len(columns), dtype=bool)

    def place(wrong: np.ndarray) -> Place:
        marks[start[wrong]] = True
        return columns.place(marks)

    reached = np.linalg.norm(action[:, schema.POSITION] - state[:, schema.POSITION], axis=1) < _NEAR
    key, advice = schema.ACTION, "check the labels: shuffled, of another episode, or state and action swapped?"
    if reached.mean() < 0.5:
        got = f"{reached.sum()} of {len(reached)} that are"
        yield Finding(key, f"the hand's place at the next keyframe ({schema.STATE})", got, advice.rstrip("?"),
                      place(~reached))  # fmt: skip
        return
    turn, told = state[:, schema.QUATERNION], action[:, schema.QUATERNION]
    alike = _alike(told, turn)
    if alike.mean() < 0.5:
        other = max(_alike(told[:, _WXYZ], turn).mean(), _alike(told, turn[:, _WXYZ]).mean())
        got = f"{alike.sum()} of {len(alike)} that are"
        got += ", but most of them with w taken for the first number" if other >= 0.5 else ""
        yield Finding(key, f"the hand's turn at the next keyframe ({schema.STATE}), both xyzw", got,
                      "write quaternions as xyzw", place(~alike))  # fmt: skip
    yield from _gripper(
        action[:, schema.GRIPPER] > 0.5, state[:, schema.GRIPPER], columns.hand[:, schema.GRIPPER], place
    )


def _gripper(
    opened: np.ndarray, reached: np.ndarray, openings: np.ndarray, place: Callable[[np.ndarray], Place]
) -> Iterator[Finding]:
    """What was commanded open, the opening reached then, and the openings of all rows: (K,), (K,), (N,)."""
    widest = openings.max()
    if 0.01 < widest <= _METRES and np.ptp(openings) > 0.01:
        got, advice = f"an opening of at most {widest:.3g}: metres?", "divide the opening by its range"
        yield Finding(schema.STATE, f"the gripper as {schema.ACTION} left it", got, advice, place(opened),
                      certain=bool(opened.any()))  # fmt: skip
    elif opened.any() and not opened.all() and reached[opened].mean() < reached[~opened].mean():
        got = f"an opening of {reached[opened].mean():.2g} where it is open and {reached[~opened].mean():.2g} elsewhere"
        advice = "write 1 for an open gripper and 0 for a closed one"
        yield Finding(schema.STATE, f"the gripper as {schema.ACTION} left it", got, advice, place(opened))


def _alike(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.abs((one * other).sum(axis=1)) > _ALIKE


def _pairs(columns: Columns, dense: bool) -> tuple[np.ndarray, np.ndarray]:
    """Rows, and for each the row of the keyframe that its action leads to."""
    starts: list[np.ndarray] = []
    ends: list[np.ndarray] = []
    index, marked = columns[schema.KEYFRAME_INDEX], columns[schema.IS_KEYFRAME].astype(bool)
    for rows in columns.episodes():
        count = rows.stop - rows.start
        if is_visited(columns, rows):
            continue
        if dense:
            following = columns[schema.NEXT_KEYFRAME][rows]
            here = np.flatnonzero((following >= 0) & (following < count))
            starts.append(rows.start + here)
            ends.append(rows.start + following[here])
            continue
        for row in np.flatnonzero(marked[rows]) + rows.start:
            before = np.flatnonzero(index[rows] == index[row] - 1) + rows.start
            starts.append(before)
            ends.append(np.full(len(before), row))
    if not starts:
        return np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    return np.concatenate(starts).astype(int), np.concatenate(ends).astype(int)
