"""Which frames of a demonstration become training samples, and how much each counts (paper, III-B and III-C)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError

SamplingMode = Literal["thin", "repeat", "weight"]


def sampling_mode(name: str) -> SamplingMode:
    """The sampling mode of a name.

    Raises:
        LlakeyError: if there is none.
    """
    modes: dict[str, SamplingMode] = {"thin": "thin", "repeat": "repeat", "weight": "weight"}
    if name not in modes:
        raise LlakeyError(
            f"Expected a mode of keysteps out of thin, repeat and weight, got {name!r}; pick one of these."
        )
    return modes[name]


@dataclass(frozen=True)
class Balance:
    """How samples right at keyframes are balanced against those in between.

    A segment starts at frame 0 or at a keyframe and ends before the next keyframe, which is what its samples lead to.
    Its first frame is the *keyframe sample*: seen from there, the next instruction has just changed. All other samples
    are in-between samples. The paper takes every tenth frame, tops each segment up to three samples at random, and
    counts the keyframe samples six times: the defaults.

    Attributes:
        mode: how keyframe samples come to count that often. "repeat" stores them that often; "thin" keeps the same
            proportions without duplicates: each keyframe sample once, each in-between sample with probability
            ``1 / keyframe_repeats``; "weight" stores every sample once and writes what it counts into the column
            ``observation.sample_weight``, which both policies' losses read.
        stride: take every ``stride``-th frame.
        min_per_segment: samples a segment, its keyframe sample included; fewer only where it has fewer frames.
        keyframe_repeats: how often a keyframe sample counts.

    Raises:
        LlakeyError: if the mode is unknown or a number is below 1.
    """

    mode: SamplingMode = "thin"
    stride: int = 10
    min_per_segment: int = 3
    keyframe_repeats: int = 6

    def __post_init__(self) -> None:
        sampling_mode(self.mode)
        if min(self.stride, self.min_per_segment, self.keyframe_repeats) < 1:
            raise LlakeyError(
                f"Expected stride, min_per_segment and keyframe_repeats of 1 or more, got {self.stride}, "
                f"{self.min_per_segment} and {self.keyframe_repeats}; correct the one that is not."
            )

    def select(self, keyframes: Sequence[int], length: int, rng: np.random.Generator) -> list[int]:
        """The frames of an episode to train on, in order. The last frame leads nowhere and is never taken.

        Args:
            keyframes: increasing frame indices above 0 that end at ``length - 1``.
            length: number of frames of the episode.
            rng: draws the samples that top up, and in mode "thin" those that stay.

        Raises:
            LlakeyError: if the keyframes do not fit the length.
        """
        starts = [0, *keyframes]
        if len(starts) < 2 or starts[-1] != length - 1 or any(a >= b for a, b in pairwise(starts)):
            raise LlakeyError(
                f"Expected increasing keyframes above 0 that end at the last frame {length - 1}, got "
                f"{list(keyframes)}; use those of the same episode."
            )
        chosen: list[int] = []
        for first, stop in pairwise(starts):
            between = [frame for frame in range(first + 1, stop) if frame % self.stride == 0]
            others = [frame for frame in range(first + 1, stop) if frame % self.stride]
            missing = min(max(0, self.min_per_segment - 1 - len(between)), len(others))
            between += rng.choice(others, missing, replace=False).tolist() if missing else []
            if self.mode == "thin":
                between = [frame for frame in between if rng.random() * self.keyframe_repeats < 1]
            chosen += [first] * (self.keyframe_repeats if self.mode == "repeat" else 1) + sorted(between)
        return chosen

    def features(self) -> dict[str, dict[str, Any]]:
        """The columns that a dataset of these samples has beside the contract's."""
        return {schema.SAMPLE_WEIGHT: {"dtype": "float32", "shape": (1,), "names": None}} if self._weighs else {}

    def columns(self, frame: int, keyframes: Sequence[int]) -> dict[str, np.ndarray]:
        """These columns for a frame of an episode with such keyframes."""
        if not self._weighs:
            return {}
        counts = self.keyframe_repeats if frame == 0 or frame in keyframes else 1
        return {schema.SAMPLE_WEIGHT: np.array([counts], dtype=np.float32)}

    @property
    def _weighs(self) -> bool:
        return self.mode == "weight"


PAPER = Balance()
"""The paper's proportions, without duplicates."""
