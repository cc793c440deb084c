"""Actions that are what the hand reached at the next keyframe, as the data contract has it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import Columns
from lerobot_llakey.checks.finding import Finding
from lerobot_llakey.checks.order import is_visited
from lerobot_llakey.labels import OPEN_ABOVE

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
    if not columns.has(schema.STATE, schema.ACTION, schema.KEYFRAME_INDEX, schema.NEXT_KEYFRAME, schema.IS_KEYFRAME):
        return
    start, end = _pairs(columns, dense)
    if len(start) < _FEW:
        return
    action, state = columns[schema.ACTION][start].astype(float), columns[schema.STATE][end].astype(float)
    marks = np.zeros(len(columns), dtype=bool)

    def place(wrong: np.ndarray) -> str:
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
    yield from _gripper(action[:, schema.GRIPPER] > 0.5, state[:, schema.GRIPPER], columns, place)


def _gripper(opened: np.ndarray, opening: np.ndarray, columns: Columns, place: object) -> Iterator[Finding]:
    fits = opened == (opening > OPEN_ABOVE)
    widest = columns[schema.STATE][:, schema.GRIPPER].max()
    small = 0.01 < widest <= _METRES
    if fits.mean() < 0.5 or (small and opened.any()):
        got = f"an opening of at most {widest:.3g}: metres?" if small else f"{(~fits).sum()} of {len(fits)} opposite"
        advice = "divide the opening by its range" if small else "write 1 for an open gripper and 0 for a closed one"
        yield Finding(schema.STATE, f"the gripper as {schema.ACTION} left it", got, advice, place(~fits))  # type: ignore[operator]
    elif small and not opened.any() and np.ptp(columns[schema.STATE][:, schema.GRIPPER]) > 0.01:
        got = f"an opening of at most {widest:.3g}: metres?"
        yield Finding(schema.STATE, "a gripper that opens", got, "divide the opening by its range", certain=False)


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
