"""Keyframes that are worth learning: where the gripper opens and closes, apart from each other, one action each."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import Columns
from lerobot_llakey.checks.finding import Finding, told
from lerobot_llakey.checks.motion import STILL, STILL_TURN, moved
from lerobot_llakey.checks.order import is_visited

_RANGE = 0.1
"""Opening that a gripper must vary by in a file for its signal to tell anything."""
_CHANGE, _SAME = 0.4, 0.02
"""Shares of that range: a gripper that opened or closed, and one that did not stir."""
_BESIDE = 0.05
"""Metres from a keyframe within which opening or closing belongs to it."""
_ALIKE = 1e-4
_ANEW = "label the recordings anew with llakey annotate"


def check_segments_actions(columns: Columns) -> Iterator[Finding]:
    """All frames that lead to one keyframe carry its one action."""
    if not columns.has(schema.ACTION, schema.KEYFRAME_INDEX):
        return
    action, wrong = columns[schema.ACTION], np.zeros(len(columns), dtype=bool)
    index = columns[schema.KEYFRAME_INDEX]
    for rows in columns.episodes():
        within = np.diff(index[rows]) == 0
        wrong[rows][1:] = within & ~(np.abs(np.diff(action[rows], axis=0)) <= _ALIKE).all(axis=1)
    if wrong.any():
        expected = "one action for all frames of a segment"
        yield Finding(schema.ACTION, expected, told(action[wrong][0]), _ANEW, columns.place(wrong), certain=False)


def check_spacing(columns: Columns) -> Iterator[Finding]:
    """Warn of keyframes that are the one before again: the same pose, gripper and collision flag.

    After an unforeseen event the same keyframe may well be gone to again.
    """
    if not columns.has(schema.ACTION, schema.KEYFRAME_INDEX):
        return
    action, index = columns[schema.ACTION], columns[schema.KEYFRAME_INDEX]
    wrong = np.zeros(len(columns), dtype=bool)
    for rows in columns.episodes():
        if is_visited(columns, rows):
            continue
        step = np.flatnonzero(np.diff(index[rows]) == 1) + rows.start
        step = np.array([row for row in step if not _disturbed(columns, row, row + 1)], dtype=int)
        if not len(step):
            continue
        before, after = action[step], action[step + 1]
        apart, turn = moved(after, before)
        alike = (before[:, schema.GRIPPER :] > 0.5) == (after[:, schema.GRIPPER :] > 0.5)
        wrong[step + 1] = (apart < STILL) & (turn < STILL_TURN) & alike.all(axis=1)
    if wrong.any():
        expected = "keyframes that differ from the one before in pose or gripper"
        got = f"one within {1000 * STILL:.0f} mm and {np.rad2deg(STILL_TURN):.0f} degrees"
        advice = "merge the two segments: llakey annotate takes a CSV without that keyframe"
        yield Finding(schema.ACTION, expected, got, advice, columns.place(wrong), certain=False)


def check_gripper(columns: Columns, dense: bool) -> Iterator[Finding]:
    """Warn of openings and closings that no keyframe marks, and of keyframes that tell of others.

    What an unforeseen event does to the gripper is left out.

    Args:
        columns: of a file.
        dense: whether it holds whole recordings.
    """
    if not dense or columns.hand is None or not columns.has(schema.IS_KEYFRAME, schema.ACTION):
        return
    opening = columns.hand[:, schema.GRIPPER].astype(float)
    spread = float(np.ptp(opening)) if len(opening) else 0.0
    if not spread > _RANGE:  # a NaN is told elsewhere
        return
    share = (opening - opening.min()) / spread
    unmarked, untrue = np.zeros(len(columns), dtype=bool), np.zeros(len(columns), dtype=bool)
    changes = 0
    for rows in columns.episodes():
        marks = np.flatnonzero(columns[schema.IS_KEYFRAME][rows].astype(bool)) + rows.start
        for start, end in zip([rows.start, *marks], marks, strict=False):
            if _disturbed(columns, start, end):
                continue
            frame = _unmarked(share, columns.hand, start, end)
            if frame is not None:
                unmarked[frame] = True
            if start > rows.start:
                commanded = columns[schema.ACTION][[start - 1, end - 1], schema.GRIPPER] > 0.5
                by, told_so = abs(share[end] - share[start]), bool(commanded[0] != commanded[1])
                changes += told_so or by > 2 * _CHANGE
                untrue[end] = by < _SAME if told_so else by > 2 * _CHANGE
    if unmarked.any():
        got = f"one {int(unmarked.sum())} times that no keyframe marks"
        advice = "add keyframes where the gripper opens and closes"
        yield Finding(schema.IS_KEYFRAME, "a keyframe wherever the gripper opens or closes", got, advice,
                      columns.place(unmarked), certain=False)  # fmt: skip
    if untrue.sum() > max(1, changes / 2):
        got = f"{int(untrue.sum())} of {changes} that did not, or did untold"
        yield Finding(schema.ACTION, "grippers that open and close as the keyframes say", got, _ANEW,
                      columns.place(untrue), certain=False)  # fmt: skip


def _disturbed(columns: Columns, start: int, end: int) -> bool:
    if schema.EPISODE_EVENT not in columns:
        return False
    return any(columns[schema.EPISODE_EVENT][start : end + 1])


def _unmarked(share: np.ndarray, hand: np.ndarray, start: int, end: int) -> int | None:
    """The frame of a segment at which the gripper opens or closes away from both its keyframes."""
    part, low, high = share[start : end + 1], *sorted((share[start], share[end]))
    if part.max() - high > _CHANGE or low - part.min() > _CHANGE:
        return start + int(np.argmax(np.maximum(part - high, low - part)))
    if high - low <= _CHANGE:
        return None
    crossed = np.flatnonzero(np.diff((part > (low + high) / 2).astype(int)))
    frame = start + int(crossed[0]) + 1
    places = hand[[start, frame, end], schema.POSITION]
    apart = np.linalg.norm(places[[0, 2]].astype(float) - places[1], axis=1)
    return frame if apart.min() > _BESIDE else None
