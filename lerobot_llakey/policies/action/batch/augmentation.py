"""Random rigid motions of the whole scene (PerAct, RVT): cloud, target and present pose move together.

Two more augmentations move nothing: recoloured clouds, and noise on the hand's orientation in the proprioception.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import torch
from torch import Tensor
from torch.nn import functional as F

from lerobot_llakey import geometry, schema
from lerobot_llakey.policies.action.batch.point_cloud import PointCloud


@dataclass
class RigidMotion:
    """A rotation about the vertical through a pivot, then a translation; one for each row of a batch.

    Attributes:
        yaw: (B,) radians.
        pivot: (B, 3) metres.
        translation: (B, 3) metres.
    """

    yaw: Tensor
    pivot: Tensor
    translation: Tensor

    @property
    def rotation(self) -> Tensor:
        """The rotations as matrices (B, 3, 3)."""
        cos, sin, zero = self.yaw.cos(), self.yaw.sin(), torch.zeros_like(self.yaw)
        return torch.stack((cos, -sin, zero, sin, cos, zero, zero, zero, zero + 1), dim=-1).unflatten(-1, (3, 3))

    def move_points(self, points: Tensor) -> Tensor:
        """One point (B, 3) for each row, in metres, after the motion."""
        turned = (self.rotation @ (points - self.pivot)[..., None]).squeeze(-1)
        return turned + (self.pivot + self.translation)  # exact for the pivot: rounding moves no target out

    def move_quaternion(self, quaternion: Tensor) -> Tensor:
        """Quaternions (B, 4) xyzw after the motion."""
        return geometry.matrix_to_quaternion(self.rotation @ geometry.quaternion_to_matrix(quaternion))

    def move_poses(self, poses: Tensor) -> Tensor:
        """Poses (B, 7) of hands or cameras after the motion: moving the cameras moves all that they see."""
        quaternion = F.normalize(poses[:, schema.QUATERNION], dim=-1)
        return torch.cat((self.move_points(poses[:, schema.POSITION]), self.move_quaternion(quaternion)), dim=-1)


def sample_motion(target: Tensor, workspace: Tensor, translation: float, yaw_degrees: float) -> RigidMotion:
    """Draw a motion for each target position (B, 3) that leaves it inside the workspace (3, 2), both in metres.

    The rotation is about the target itself, so that only the translation moves it, and that is limited to what fits.
    """
    yaw = (torch.rand(target.shape[0], device=target.device) * 2 - 1) * math.radians(yaw_degrees)
    margin = 0.01 * (workspace[:, 1] - workspace[:, 0])
    low = (workspace[:, 0] + margin - target).clamp(-translation, 0.0)
    high = (workspace[:, 1] - margin - target).clamp(0.0, translation)
    shift = low + torch.rand_like(target) * (high - low)
    return RigidMotion(yaw, target, shift)


def blurred(quaternion: Tensor, degrees: float) -> Tensor:
    """Orientations of the hand with random errors, for training.

    In demonstrations the hand reaches an object already oriented as the grasp needs it. A policy conditioned on the
    exact orientation learns to keep it, its own errors included; conditioned on a noisy one, it has to look.

    Args:
        quaternion: (B, 4) unit, xyzw.
        degrees: standard deviation of the error about each axis of the hand.
    """
    vector = torch.randn(len(quaternion), 3, device=quaternion.device) * math.radians(degrees)
    angle = vector.norm(dim=1, keepdim=True).clamp(min=1e-9)
    error = torch.cat((vector / angle * (angle / 2).sin(), (angle / 2).cos()), dim=1)
    hand, rotation = geometry.quaternion_to_matrix(quaternion), geometry.quaternion_to_matrix(error)
    return geometry.matrix_to_quaternion(hand @ rotation)


def jittered(cloud: PointCloud, batch: int, colour_jitter: float) -> PointCloud:
    """The clouds of a batch in other colours; at 0 the same cloud.

    Args:
        cloud: of the whole batch.
        batch: number of rows B.
        colour_jitter: red, green and blue of a row are each multiplied by a number in 1 -+ this, and stay in 0..1.
    """
    if colour_jitter == 0:
        return cloud
    gain = 1 + (torch.rand(batch, 3, device=cloud.colours.device) * 2 - 1) * colour_jitter
    return replace(cloud, colours=(cloud.colours * gain[cloud.rows]).clamp(0.0, 1.0))
