"""Numbers that no network can learn from: not finite, or outside what their unit allows."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import Columns
from lerobot_llakey.checks.finding import Finding, told

_SLACK = 0.05
"""By how much an opening may leave 0..1: sensors overshoot."""


def check_finite(columns: Columns, reads: Collection[str]) -> Iterator[Finding]:
    """Every number of the columns that are read is finite, and every row has one."""
    for key, what in columns.odd.items():
        if key in reads:
            yield Finding(key, "values of the kind and shape that info.json gives", what, "write the dataset anew")
    for key, values in columns.values.items():
        if key not in reads or not np.issubdtype(values.dtype, np.floating):
            continue
        wrong = ~np.isfinite(values).reshape(len(values), -1).all(axis=1)
        if wrong.any():
            got = values[wrong][0].reshape(-1)
            worst = got[~np.isfinite(got)][0]
            yield Finding(key, "finite numbers", f"{worst}", "correct or drop these rows", columns.place(wrong))


def check_state(columns: Columns) -> Iterator[Finding]:
    """Hand, gripper and joints of the state are in their units."""
    if columns.hand is None or columns.joints is None:
        return
    key, hand = schema.STATE, columns.hand
    position = hand[:, schema.POSITION]
    yield from _far(columns, key, position)
    yield from _no_place(columns, key, position)
    yield from _unit(columns, key, hand[:, schema.QUATERNION])
    opening = hand[:, schema.GRIPPER]
    wrong = (opening < -_SLACK) | (opening > 1 + _SLACK)
    if wrong.any():
        got = f"{opening[wrong][0]:g} (0..{opening.max():g} in all)"
        yield Finding(key, "the gripper's opening from 0 to 1", got, "divide it by its range", columns.place(wrong))
    joints = np.abs(columns.joints).max(axis=1, initial=0.0)
    for limit, certain in ((4 * np.pi, True), (2 * np.pi, False)):
        if (joints > limit).any():
            got = f"{joints[joints > limit][0]:.1f}"
            advice = "convert degrees to radians"
            yield Finding(key, "joints in radians", got, advice, columns.place(joints > limit), certain)
            return


def check_action(columns: Columns, workspace: schema.Workspace | None) -> Iterator[Finding]:
    """Targets lie in the workspace, with a rotation and flags that are some."""
    if schema.ACTION not in columns:
        return
    key, action = schema.ACTION, columns[schema.ACTION]
    position = action[:, schema.POSITION]
    if workspace is None:
        yield from _far(columns, key, position)
    else:
        low, high = np.array(workspace, dtype=np.float64).T
        # A bound is excluded above, as the policy has it.
        outside = np.isfinite(position).all(axis=1) & ~((position >= low) & (position < high)).all(axis=1)
        if outside.any():
            expected = f"keyframes in metres inside the workspace {[list(bounds) for bounds in workspace]}"
            advice = "convert their unit or widen policy.workspace"
            yield Finding(key, expected, told(position[outside][0]), advice, columns.place(outside))
    yield from _no_place(columns, key, position)
    yield from _unit(columns, key, action[:, schema.QUATERNION])
    flags = action[:, [schema.GRIPPER, schema.IGNORE_COLLISION]]
    wrong = np.any((flags < 0) | (flags > 1), axis=1)
    if wrong.any():
        advice = "write 1 for open and for touching, else 0"
        yield Finding(key, "flags from 0 to 1 for the gripper and for collisions", told(flags[wrong][0]), advice,
                      columns.place(wrong))  # fmt: skip


def check_weights(columns: Columns, key: str) -> Iterator[Finding]:
    """Weights of samples, where there are some, are 0 or more, and not all 0."""
    if key not in columns:
        return
    weights = columns[key]
    wrong = weights < 0
    if wrong.any():
        yield Finding(key, "weights of 0 or more", f"{weights[wrong][0]:g}", "correct it", columns.place(wrong))
    if len(weights) and (weights == 0).all():
        yield Finding(key, "a sample that counts", "weights of 0 alone", "correct the weights or drop the column")


def _far(columns: Columns, key: str, position: np.ndarray) -> Iterator[Finding]:
    far = np.abs(position).max(axis=1) > schema.FARTHEST
    if far.any():
        advice = "convert millimetres or centimetres, or check which numbers are the position"
        yield Finding(key, "the hand's position in metres", told(position[far][0]), advice, columns.place(far))


def _unit(columns: Columns, key: str, quaternion: np.ndarray) -> Iterator[Finding]:
    length = np.linalg.norm(quaternion.astype(np.float64), axis=1)
    wrong = np.abs(length - 1) > schema.UNIT_TOLERANCE
    if wrong.any():
        got = f"{told(quaternion[wrong][0])} of length {length[wrong][0]:.3g}"
        advice = "write the hand's rotation as xyzw of length 1"
        yield Finding(key, "a unit quaternion", got, advice, columns.place(wrong))


def _no_place(columns: Columns, key: str, position: np.ndarray) -> Iterator[Finding]:
    nowhere = (position == 0).all(axis=1)
    if nowhere.any():
        advice = "record the hand's position in the base's frame"
        yield Finding(key, "a place of the hand", "0, 0, 0", advice, columns.place(nowhere))
