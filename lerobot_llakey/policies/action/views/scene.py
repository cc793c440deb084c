"""The input of the stages."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor


@dataclass
class Scene:
    """Cloud, words and hand of a batch, in coordinates of the unit cube that spans the workspace.

    Attributes:
        points: (M, 3) of all batch rows, end to end.
        colours: (M, 3) in 0..1.
        rows: (M,) int64 batch row of each point.
        base: (B, 3) where the workspace's lower corner lies once augmentation has moved the scene; else zero. Only its
            height is used: heights are relative to the base, so that what is fixed there survives augmentation.
        effector: (B, 3) the present end effector, NaN without the hand's pose.
        condition: (B, D) text and proprioception, or proprioception alone: as the design's network takes it.
        words: (B, T, W) word vectors; padding: (B, T) bool, true where there is no word.
    """

    points: Tensor
    colours: Tensor
    rows: Tensor
    base: Tensor
    effector: Tensor
    condition: Tensor
    words: Tensor
    padding: Tensor
