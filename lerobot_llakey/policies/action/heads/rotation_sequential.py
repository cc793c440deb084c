"""Rotation about x, then y given x, then z given both (RVT-2)."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from lerobot_llakey.policies.action.heads.pose_heads import (
    PoseHead,
    PoseOutput,
    bins_loss,
    bins_quaternion,
    heading_angles,
    sum_votes,
)
from lerobot_llakey.policies.action.heads.targets import bin_angles, rotation_target

_ORDER = (2, 1, 0)
"""The angles (a, b, c) of :mod:`targets` are about z, y and x."""
_HARMONICS = 8


def _perceptron(inputs: int, width: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Linear(inputs, width),
        nn.GELU(),
        nn.Linear(width, width // 2),
        nn.GELU(),
        nn.Linear(width // 2, outputs),
    )


class SequentialBinsHead(PoseHead):
    """Three angles in bins, each conditioned on those before it: the true ones in training, else the likeliest ones.

    A grasp that fits in two ways then gets one of them, never an angle of each. RVT-2 adds a positional code of the
    bin's number to the features; here it is harmonics of the angle, for which the first and last bin are neighbours.

    Args:
        inputs: width of the input vector.
        bins: of each angle.
        width: of the hidden layers; the second has half of it.
        frames: see :class:`PoseHead`.
    """

    def __init__(
        self, inputs: int, bins: int, width: int = 256, frames: Sequence[str] = ("view", "hand", "base")
    ) -> None:
        super().__init__(frames)
        self.bins = bins
        self.norm = nn.LayerNorm(inputs)
        self.flags = _perceptron(inputs, width, 4)
        self.votes = nn.ModuleList(_perceptron(inputs, width, len(self.frames) * bins) for _ in _ORDER)
        self.condition = nn.ModuleList(nn.Linear(2 * _HARMONICS, inputs) for _ in _ORDER[:-1])

    def forward(self, features: Tensor, present: Tensor, heading: Tensor, truth: Tensor | None = None) -> PoseOutput:
        known = self.norm(features)
        flags = self.flags(known).float()
        base = heading_angles(heading)
        target = None if truth is None else rotation_target(truth, self.bins)
        logits: dict[int, Tensor] = {}
        for order, axis in enumerate(_ORDER):
            votes = self.votes[order](known).float().unflatten(-1, (len(self.frames), self.bins)).transpose(0, 1)
            logits[axis] = sum_votes(votes, self.frames, present[:, axis], base[:, axis])
            if order < len(self.condition):
                likeliest = F.one_hot(logits[axis].argmax(dim=-1), self.bins).float()
                chosen = likeliest if target is None else target[:, axis]
                known = known + self.condition[order](self._harmonics(chosen))
        rotation = torch.stack([logits[axis] for axis in sorted(logits)], dim=1)
        return PoseOutput(rotation, flags[:, :2], flags[:, 2:])

    def _harmonics(self, chosen: Tensor) -> Tensor:
        """Mean harmonics (B, 2 * _HARMONICS) of the angle over the bins' probabilities (B, bins)."""
        orders = torch.arange(1, _HARMONICS + 1, device=chosen.device)
        phases = bin_angles(torch.arange(self.bins, device=chosen.device), self.bins)[:, None] * orders
        return chosen @ torch.cat((phases.sin(), phases.cos()), dim=-1)

    def rotation_loss(self, output: PoseOutput, truth: Tensor) -> Tensor:
        return bins_loss(output.rotation, truth)

    def quaternion(self, output: PoseOutput) -> Tensor:
        return bins_quaternion(output.rotation)
