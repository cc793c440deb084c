"""The segments between keyframes, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lerobot_llakey.errors import LlakeyError


@dataclass(frozen=True)
class Segments:
    """What the keyframe columns of a dataset hold, one entry a frame.

    Attributes:
        index: (T,) int64, the segment in which the frame is a starting point: the number of keyframes up to and
            including it. A keyframe thus starts the segment that leads to the next one; the last frame, with nothing
            left to do, stays in the last segment.
        next_frame: (T,) int64, the keyframe that ends that segment; the last frame's is itself.
        is_keyframe: (T,) bool.
    """

    index: npt.NDArray[np.int64]
    next_frame: npt.NDArray[np.int64]
    is_keyframe: npt.NDArray[np.bool_]


def segments(keyframes: list[int], length: int) -> Segments:
    """The segments between keyframes, frame by frame.

    Args:
        keyframes: increasing frame indices, the last one ``length - 1``, as the rules give them.
        length: number of frames T.

    Raises:
        LlakeyError: if the keyframes do not increase, hold frame 0 or do not end at the last frame.
    """
    frames: np.ndarray[Any, np.dtype[np.int64]] = np.asarray(keyframes, dtype=np.int64)
    if len(frames) == 0 or frames[0] <= 0 or frames[-1] != length - 1 or np.any(np.diff(frames) <= 0):
        raise LlakeyError(
            f"Expected increasing keyframes above 0 that end at the last frame {length - 1}, got {list(keyframes)}; "
            "take them from a rule of lerobot_llakey.keyframes."
        )
    index = np.searchsorted(frames, np.arange(length), side="right").clip(max=len(frames) - 1)
    is_keyframe = np.zeros(length, dtype=bool)
    is_keyframe[frames] = True
    return Segments(index.astype(np.int64), frames[index], is_keyframe)
