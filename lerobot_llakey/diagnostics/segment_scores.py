"""How well found keyframes, and the segments between them, agree with the true ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

OVERLAPS = (0.10, 0.25, 0.50)
"""The overlaps at which temporal action segmentation reports F1 (Lea et al. 2017, "Temporal convolutional networks for
action segmentation and detection")."""


def matches(found: Sequence[int], truth: Sequence[int], within: int = 3) -> int:
    """How many found keyframes have a true one of their own within so many frames; the best pairing counts."""
    if not found or not truth:
        return 0
    near = np.abs(np.subtract.outer(np.asarray(found), np.asarray(truth))) <= within
    rows, columns = linear_sum_assignment(~near)
    return int(near[rows, columns].sum())


def segments_matched(found: Sequence[int], truth: Sequence[int], overlap: float) -> int:
    """True positives of the F1 at an overlap: segments whose intersection over union with a true one is as large.

    A segment leads from one keyframe (or frame 0) to the next; labels play no part. Each true segment counts once: of
    several found ones that overlap it the first is right and the others are false, as in the published measure.
    """
    ends, true_ends = np.asarray(found), np.asarray(truth)
    starts, true_starts = np.concatenate(([0], ends[:-1])), np.concatenate(([0], true_ends[:-1]))
    taken: set[int] = set()
    for start, end in zip(starts, ends, strict=True):
        shared = (np.minimum(end, true_ends) - np.maximum(start, true_starts)).clip(min=0)
        union = np.maximum(end, true_ends) - np.minimum(start, true_starts)
        best = int(np.argmax(shared / union))
        if shared[best] / union[best] >= overlap and best not in taken:
            taken.add(best)
    return len(taken)


def f1(right: int, found: int, truth: int) -> float:
    """The harmonic mean of precision and recall."""
    return 2 * right / (found + truth) if found + truth else 0.0
