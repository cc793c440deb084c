"""Keyframes that were found in recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lerobot_llakey.errors import LlakeyError


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


def chosen_keyframes(episode: int, frames: Sequence[int], length: int) -> list[int]:
    """Keyframes that a person chose, as long as they fit an episode of ``length`` frames.

    Raises:
        LlakeyError: if one lies outside the episode, or the last frame is missing.
    """
    outside = [frame for frame in frames if not 0 < frame < length]
    if outside:
        raise LlakeyError(
            f"Expected keyframes from frame 1 to {length - 1} in episode {episode}, got frame {outside[0]}; correct it."
        )
    if not frames or max(frames) != length - 1:
        got = f"{max(frames)} as the last one" if frames else "none"
        raise LlakeyError(
            f"Expected the last frame, {length - 1}, among the keyframes of episode {episode}, since an episode ends "
            f"with its last action, got {got}; add a row for frame {length - 1}, or move the last keyframe there."
        )
    return sorted(frames)


def few_keyframes(found: Sequence[FoundKeyframes], rules: Sequence[str]) -> str:
    """A sentence that suggests another rule where most episodes have no keyframe but their last frame; else empty."""
    single = sum(len(episode.keyframes) == 1 for episode in found)
    if not found or 2 * single <= len(found):
        return ""
    other = "rest" if "waypoints" in rules else "waypoints"
    return (
        f"Expected several keyframes an episode, got only the last frame in {single} of {len(found)} episodes by "
        f"{'+'.join(rules)}; try --keyframes={other}, and check the units of the state."
    )
