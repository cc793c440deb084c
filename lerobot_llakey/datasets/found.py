"""Keyframes that were found in recordings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class FoundKeyframes:
    """An episode's keyframes.

    Attributes:
        episode: its index.
        task: skill instruction.
        states: (T, N) in the contract's terms, quaternions without jumps.
        names: of the states' numbers.
        opened: (T,) bool, whether the gripper is open: as commanded or, where no command tells, as far as it gets.
        keyframes: discovered frames; the last one is T - 1.
        fps: frames a second.
    """

    episode: int
    task: str
    states: np.ndarray
    names: tuple[str, ...]
    opened: np.ndarray
    keyframes: list[int]
    fps: float

    def seconds(self, segment: int) -> tuple[float, float]:
        """When a segment begins and ends."""
        starts = [0, *self.keyframes]
        return starts[segment] / self.fps, starts[segment + 1] / self.fps
