"""The box that a dataset's keyframes need: the workspace of a policy that is told none."""

from __future__ import annotations

from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.dataset_columns import tables_of

MARGIN = 0.15
"""Metres on each side: half of a zoomed-in crop, and the shift that training adds."""
_GRAIN = 100
"""Bounds a metre: they are rounded outwards to whole centimetres."""


def keyframe_box(dataset_meta: Any) -> list[list[float]]:
    """Bounds of x, y and z in metres around all keyframe positions of a dataset, with a margin.

    Args:
        dataset_meta: a ``LeRobotDatasetMetadata``.

    Raises:
        LlakeyError: if its files are not on this disk or hold no usable position.
    """
    lows, highs = [], []
    for table in tables_of(dataset_meta, [schema.ACTION]):
        column = table.column(schema.ACTION).combine_chunks()
        if not len(column):
            continue
        places = np.stack(column.to_numpy(zero_copy_only=False))[:, schema.POSITION].astype(float)
        # What is no position of an arm is told when the dataset is checked.
        places = places[(np.abs(places) <= schema.FARTHEST).all(axis=1)]
        if len(places):
            lows.append(places.min(axis=0))
            highs.append(places.max(axis=0))
    if not lows:
        raise LlakeyError(
            f"Expected keyframe positions in the column {schema.ACTION} of {dataset_meta.repo_id!r} for "
            "workspace='auto', got none on this disk; give policy.workspace as three (low, high) pairs in metres."
        )
    low, high = np.min(lows, axis=0) - MARGIN, np.max(highs, axis=0) + MARGIN
    box = np.stack((np.floor(low * _GRAIN), np.ceil(high * _GRAIN)), axis=1) / _GRAIN
    bounds: list[list[float]] = box.clip(-schema.FARTHEST, schema.FARTHEST).tolist()
    return bounds
