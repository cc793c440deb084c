"""A continuous rotation: two columns of the matrix, made orthonormal (Zhou et al., CVPR 2019)."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from lerobot_llakey import geometry
from lerobot_llakey.policies.action.heads.pose_heads import PoseHead, PoseOutput
from lerobot_llakey.policies.action.heads.targets import angles_to_quaternion

_ROUNDING = 1e-8


def orthonormal(columns: Tensor) -> Tensor:
    """Rotation matrices (..., 3, 3) from any two columns (..., 3, 2) that are not parallel, by Gram and Schmidt."""
    first = F.normalize(columns[..., 0], dim=-1)
    second = columns[..., 1] - (first * columns[..., 1]).sum(dim=-1, keepdim=True) * first
    second = F.normalize(second, dim=-1)
    return torch.stack((first, second, torch.linalg.cross(first, second)), dim=-1)


def chordal_angle(first: Tensor, second: Tensor) -> Tensor:
    """Distance (...) of rotation matrices (..., 3, 3): 2 sin(angle / 2), the angle in radians where it is small.

    Its slope does not vanish on the way to zero, as that of the squared distance does, nor grow without bound near a
    half turn, as that of the arc cosine does: five degrees too much are worth correcting.
    """
    return ((first - second).square().sum(dim=(-2, -1)) / 2 + _ROUNDING).sqrt()


class SixDHead(PoseHead):
    """A rotation matrix without bins. Votes are unnormalised columns: the longer, the surer.

    Args:
        inputs: width of the input vector.
        width: of the hidden layers.
        frames: see :class:`PoseHead`.
    """

    def __init__(self, inputs: int, width: int = 256, frames: Sequence[str] = ("view", "hand", "base")) -> None:
        super().__init__(frames)
        self.layers = nn.Sequential(
            nn.LayerNorm(inputs), nn.Linear(inputs, width), nn.GELU(), nn.Linear(width, width), nn.GELU()
        )
        self.votes = nn.Linear(width, len(self.frames) * 6)
        self.flags = nn.Linear(width, 4)
        # It starts from one clear vote: near zero, the direction of the columns would be chance.
        nn.init.zeros_(self.votes.bias)
        start = torch.eye(3) if self.frames[0] == "hand" else _matrix(torch.zeros(3))
        self.votes.bias.data[:6] = start[:, :2].flatten()

    def forward(self, features: Tensor, present: Tensor, heading: Tensor, truth: Tensor | None = None) -> PoseOutput:
        hidden = self.layers(features)
        flags = self.flags(hidden).float()
        votes = self.votes(hidden).float().unflatten(-1, (len(self.frames), 3, 2))
        with torch.autocast(features.device.type, enabled=False):
            turns = {"hand": _matrix(present), "base": _yaw_matrix(heading)}
            total = torch.zeros_like(votes[:, 0])
            for vote, frame in zip(votes.unbind(1), self.frames, strict=True):
                total = total + (turns[frame] @ vote if frame in turns else vote)
            return PoseOutput(orthonormal(total), flags[:, :2], flags[:, 2:])

    def rotation_loss(self, output: PoseOutput, truth: Tensor) -> Tensor:
        return chordal_angle(output.rotation, geometry.quaternion_to_matrix(truth.to(output.rotation)))

    def quaternion(self, output: PoseOutput) -> Tensor:
        return geometry.matrix_to_quaternion(output.rotation)


def _matrix(angles: Tensor) -> Tensor:
    return geometry.quaternion_to_matrix(angles_to_quaternion(angles))


def _yaw_matrix(yaw: Tensor) -> Tensor:
    cos, sin, zero = yaw.cos(), yaw.sin(), torch.zeros_like(yaw)
    return torch.stack((cos, -sin, zero, sin, cos, zero, zero, zero, zero + 1), dim=-1).unflatten(-1, (3, 3))
