"""Rotation, gripper and collision flag from features: what every pose head has, and the one of independent bins."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from lerobot_llakey.policies.action.heads.targets import (
    angles_to_quaternion,
    bin_angles,
    rotation_target,
)


@dataclass
class PoseOutput:
    """The output of a pose head.

    Attributes:
        rotation: (B, 3, bins) logits of the three angles, or (B, 3, 3) a rotation matrix, as the head has it.
        gripper: (B, 2) logits of closed and open.
        collision: (B, 2) logits of "must not touch" and "may touch things".
    """

    rotation: Tensor
    gripper: Tensor
    collision: Tensor


class PoseHead(nn.Module, ABC):
    """Base of the pose heads.

    Up to three frames vote for the rotation: "view", that of the views ("grasp it along its side"); "hand",
    relative to the present hand ("a quarter turn on", "keep it"); and "base", relative to the robot's base, which
    augmentation turns ("straight ahead"). The votes are summed. No kind of instruction then has to learn to add
    angles, and what is fixed in the base frame survives augmentation.

    Args:
        frames: names of the frames.
    """

    def __init__(self, frames: Sequence[str]) -> None:
        super().__init__()
        self.frames = tuple(frames)

    @abstractmethod
    def forward(self, features: Tensor, present: Tensor, heading: Tensor, truth: Tensor | None = None) -> PoseOutput:
        """Read a pose.

        Args:
            features: (B, inputs).
            present: (B, 3) the hand's present angles in radians, see :mod:`targets`.
            heading: (B,) yaw of the robot's base in radians: zero but for augmentation.
            truth: (B, 4) the true quaternion xyzw, for heads whose angles depend on one another; None to predict.
        """

    @abstractmethod
    def rotation_loss(self, output: PoseOutput, truth: Tensor) -> Tensor:
        """Loss (B,) of the rotation against unit quaternions (B, 4) xyzw."""

    @abstractmethod
    def quaternion(self, output: PoseOutput) -> Tensor:
        """The rotation as unit quaternions (B, 4) xyzw with w >= 0."""


def shift_bins(logits: Tensor, angles: Tensor) -> Tensor:
    """Logits (..., bins) of angles relative to a present angle (...) in radians, as logits of absolute angles."""
    bins = logits.shape[-1]
    offset = angles * (bins / (2 * math.pi))
    whole = offset.floor()
    share = (offset - whole)[..., None]
    source = (torch.arange(bins, device=logits.device) - whole[..., None].long()) % bins
    return (1 - share) * logits.gather(-1, source) + share * logits.gather(-1, (source - 1) % bins)


def heading_angles(heading: Tensor) -> Tensor:
    """The angles (B, 3) by which a yaw (B,) of everything changes a rotation's angles: only the first."""
    return torch.stack((heading, torch.zeros_like(heading), torch.zeros_like(heading)), dim=-1)


def sum_votes(votes: Tensor, frames: Sequence[str], present: Tensor, base: Tensor) -> Tensor:
    """Logits (..., bins) from votes (F, ..., bins) in each frame; present and base are angles (...) in radians."""
    shifts = {"hand": present, "base": base}
    total = torch.zeros_like(votes[0])
    for vote, frame in zip(votes, frames, strict=True):
        total = total + (shift_bins(vote, shifts[frame]) if frame in shifts else vote)
    return total


def bins_loss(logits: Tensor, truth: Tensor) -> Tensor:
    """Cross-entropy (B,), summed over the angles, of logits (B, 3, bins) against quaternions (B, 4)."""
    target = rotation_target(truth, logits.shape[-1]).to(logits)
    return F.cross_entropy(logits.flatten(0, 1), target.flatten(0, 1), reduction="none").view(-1, 3).sum(dim=1)


def bins_quaternion(logits: Tensor) -> Tensor:
    """Quaternions (B, 4) at the centres of the likeliest bins of logits (B, 3, bins)."""
    return angles_to_quaternion(bin_angles(logits.argmax(dim=-1), logits.shape[-1]))


class BinsHead(PoseHead):
    """Three angles in bins, each predicted by itself (PerAct, RVT).

    Args:
        inputs: width of the input vector.
        bins: of each angle.
        width: of the hidden layers.
        frames: see :class:`PoseHead`.
    """

    def __init__(
        self, inputs: int, bins: int, width: int = 256, frames: Sequence[str] = ("view", "hand", "base")
    ) -> None:
        super().__init__(frames)
        self.bins = bins
        self.layers = nn.Sequential(
            nn.LayerNorm(inputs), nn.Linear(inputs, width), nn.GELU(), nn.Linear(width, width), nn.GELU()
        )
        self.votes = nn.Linear(width, len(self.frames) * 3 * bins)
        self.flags = nn.Linear(width, 4)

    def forward(self, features: Tensor, present: Tensor, heading: Tensor, truth: Tensor | None = None) -> PoseOutput:
        hidden = self.layers(features)
        flags = self.flags(hidden).float()
        votes = self.votes(hidden).float().unflatten(-1, (len(self.frames), 3, self.bins)).transpose(0, 1)
        return PoseOutput(sum_votes(votes, self.frames, present, heading_angles(heading)), flags[:, :2], flags[:, 2:])

    def rotation_loss(self, output: PoseOutput, truth: Tensor) -> Tensor:
        return bins_loss(output.rotation, truth)

    def quaternion(self, output: PoseOutput) -> Tensor:
        return bins_quaternion(output.rotation)
