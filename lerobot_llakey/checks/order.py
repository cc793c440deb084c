"""Rows in the order in which they were recorded, and keyframes that fit them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import EPISODE, FRAME, INDEX, TASKS, TIME, Columns
from lerobot_llakey.checks.finding import Finding

_AGAIN = "write the episodes anew, each row once and in the order of recording"
_LABEL = "label the recordings anew with llakey annotate"


def check_order(columns: Columns) -> Iterator[Finding]:
    """Frames of an episode count from 0, rows from the first on, and time goes on."""
    if TASKS in columns and (columns[TASKS] < 0).any():
        wrong = columns[TASKS] < 0
        got = f"{columns[TASKS][wrong][0]}"
        yield Finding(TASKS, "numbers of tasks in meta/tasks.parquet", got, _AGAIN, columns.place(wrong))
    if columns.has(EPISODE):
        first = [int(columns[EPISODE][rows.start]) for rows in columns.episodes()]
        back = np.zeros(len(columns), dtype=bool)
        for number, rows in zip(np.diff(first), columns.episodes()[1:], strict=True):
            back[rows.start] = number <= 0
        if back.any():
            got = f"episode {columns[EPISODE][back][0]} after a later one"
            yield Finding(EPISODE, "episodes one after the other", got, _AGAIN, columns.place(back))
    for key, expected in ((FRAME, "0, 1, 2, ... in each episode"), (TIME, "times that increase in each episode")):
        if key not in columns:
            continue
        wrong = np.zeros(len(columns), dtype=bool)
        for rows in columns.episodes():
            values = columns[key][rows]
            if key == FRAME:
                wrong[rows] = values != np.arange(len(values))
            else:
                wrong[rows][1:] = ~(np.diff(values) > 0)
        if wrong.any():
            yield Finding(key, expected, f"{columns[key][wrong][0]:g}", _AGAIN, columns.place(wrong))
    if INDEX in columns:
        wrong = np.concatenate(([False], np.diff(columns[INDEX]) != 1))
        if wrong.any():
            got = f"{columns[INDEX][wrong][0]}"
            yield Finding(INDEX, "rows that count up by one", got, _AGAIN, columns.place(wrong))


def is_dense(columns: Columns) -> bool:
    """Whether a file holds whole recordings, whose next keyframes are rows of their own, and not samples of them."""
    if not columns.has(schema.NEXT_KEYFRAME):
        return False
    ends = [columns[schema.NEXT_KEYFRAME][rows].max() == rows.stop - rows.start - 1 for rows in columns.episodes()]
    return bool(np.mean(ends) >= 0.5) if ends else False


def is_visited(columns: Columns, rows: slice) -> bool:
    """Whether an episode holds states that a policy visited, labelled by an expert that it did not follow (DAgger)."""
    if not columns.has(schema.NEXT_KEYFRAME, schema.KEYFRAME_INDEX):
        return False
    count = np.arange(rows.stop - rows.start)
    index, following = columns[schema.KEYFRAME_INDEX][rows], columns[schema.NEXT_KEYFRAME][rows]
    return bool((index == count).all() and (following == count + 1).all())


def check_keyframes(columns: Columns, dense: bool) -> Iterator[Finding]:
    """The columns that tell of keyframes agree with each other and with the rows.

    Args:
        columns: of a file.
        dense: whether it holds whole recordings, see :func:`is_dense`.
    """
    yield from _counted(columns)
    if schema.IS_KEYFRAME in columns:
        key, marked = schema.IS_KEYFRAME, columns[schema.IS_KEYFRAME].astype(bool)
        starts = np.zeros(len(columns), dtype=bool)
        starts[[rows.start for rows in columns.episodes()]] = True
        if (marked & starts).any():
            expected = "no keyframe at the start of an episode"
            yield Finding(key, expected, "one (is every frame one?)", _LABEL, columns.place(marked & starts))
        several = schema.KEYFRAME_INDEX in columns and columns[schema.KEYFRAME_INDEX].max(initial=0) > 0
        if len(marked) and not marked.any() and (dense or several):
            yield Finding(key, "a keyframe in every episode", "none", _LABEL)
    if dense:
        yield from _recorded(columns)
    elif columns.has(schema.NEXT_KEYFRAME, schema.KEYFRAME_INDEX):
        yield from _one_to_one(columns)


def _counted(columns: Columns) -> Iterator[Finding]:
    for key, least in ((schema.KEYFRAME_INDEX, 0), (schema.NEXT_KEYFRAME, 1), (schema.STEP, 0)):
        if key not in columns:
            continue
        wrong = columns[key] < least
        for rows in columns.episodes():
            wrong[rows][1:] |= np.diff(columns[key][rows]) < 0
        if wrong.any():
            expected = f"numbers from {least} on that never go back in an episode"
            yield Finding(key, expected, f"{columns[key][wrong][0]:g}", _LABEL, columns.place(wrong))


def _recorded(columns: Columns) -> Iterator[Finding]:
    key, following = schema.NEXT_KEYFRAME, columns[schema.NEXT_KEYFRAME]
    beyond, back, unmarked = (np.zeros(len(columns), dtype=bool) for _ in range(3))
    for rows in columns.episodes():
        count = rows.stop - rows.start
        place = following[rows]
        beyond[rows] = (place < 0) | (place >= count)
        back[rows] = place <= np.arange(count)
        back[rows.stop - 1] = False  # the last frame leads to itself
        if schema.IS_KEYFRAME in columns:
            unmarked[rows] = ~columns[schema.IS_KEYFRAME].astype(bool)[rows][place.clip(0, count - 1)]
    for wrong, expected in (
        (beyond, "frames of the same episode"),
        (back, "a later frame"),
        (unmarked & ~beyond, f"frames that {schema.IS_KEYFRAME} marks"),
    ):
        if wrong.any():
            yield Finding(key, expected, f"{following[wrong][0]}", _LABEL, columns.place(wrong))


def _one_to_one(columns: Columns) -> Iterator[Finding]:
    wrong = np.zeros(len(columns), dtype=bool)
    for rows in columns.episodes():
        index, following = columns[schema.KEYFRAME_INDEX][rows], columns[schema.NEXT_KEYFRAME][rows]
        wrong[rows][1:] = (np.diff(index) != 0) != (np.diff(following) != 0)
    if wrong.any():
        got = f"{columns[schema.NEXT_KEYFRAME][wrong][0]}"
        expected = f"one keyframe for each {schema.KEYFRAME_INDEX}"
        yield Finding(schema.NEXT_KEYFRAME, expected, got, _LABEL, columns.place(wrong))
