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
        states: (T, 15) robot states of the contract.
        keyframes: discovered frames; the last one is T - 1.
        fps: frames a second.
    """

    episode: int
    task: str
    states: np.ndarray
    keyframes: list[int]
    fps: float

    def seconds(self, segment: int) -> tuple[float, float]:
        """When a segment begins and ends."""
        starts = [0, *self.keyframes]
        return starts[segment] / self.fps, starts[segment + 1] / self.fps
