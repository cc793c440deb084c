"""Targets of the classification losses: heat maps (LLaKey section III-D, RVT) and angle bins (PerAct).

Rotations are read as R = Rz(a) Ry(b) Rx(c) R_ref, where R_ref points the hand halfway between straight down and
straight ahead. Its singular directions (b = +-90 degrees) are then 45 degrees away from both the grasp from above and
any level approach, and turning the scene about z only shifts a.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from lerobot_llakey import geometry

_HALF = math.sqrt(0.5)
# Columns are the hand's axes in the base frame; z of the hand points ahead (x) and down.
_REFERENCE = ((_HALF, 0.0, _HALF), (0.0, -1.0, 0.0), (_HALF, 0.0, -_HALF))


def quaternion_to_angles(quaternion: Tensor) -> Tensor:
    """Angles (..., 3) = (a, b, c) in radians of unit quaternions (..., 4) xyzw; b within +-pi/2."""
    reference = quaternion.new_tensor(_REFERENCE)
    matrix = geometry.quaternion_to_matrix(quaternion) @ reference.T
    a = torch.atan2(matrix[..., 1, 0], matrix[..., 0, 0])
    b = torch.asin((-matrix[..., 2, 0]).clamp(-1.0, 1.0))
    c = torch.atan2(matrix[..., 2, 1], matrix[..., 2, 2])
    return torch.stack((a, b, c), dim=-1)


def angles_to_quaternion(angles: Tensor) -> Tensor:
    """Inverse of :func:`quaternion_to_angles`: unit quaternions (..., 4) xyzw with w >= 0."""
    cos, sin = angles.cos(), angles.sin()
    (ca, cb, cc), (sa, sb, sc) = cos.unbind(-1), sin.unbind(-1)
    rows = (
        *(ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc),
        *(sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc),
        *(-sb, cb * sc, cb * cc),
    )
    matrix = torch.stack(rows, dim=-1).unflatten(-1, (3, 3)) @ angles.new_tensor(_REFERENCE)
    return geometry.matrix_to_quaternion(matrix)


def angle_bins(angles: Tensor, bins: int) -> Tensor:
    """Nearest bin (int64) of angles in radians; bin i is centred at i full turns / bins, so right angles are exact."""
    return (angles * (bins / (2 * math.pi))).round().long() % bins


def bin_angles(index: Tensor, bins: int) -> Tensor:
    """Angle in radians, in (-pi, pi], at the centre of bins."""
    angles = index * (2 * math.pi / bins)
    return torch.where(angles > math.pi, angles - 2 * math.pi, angles)


def heat_target(points: Tensor, size: int, sigma: float) -> Tensor:
    """Truncated Gaussians around points, as probabilities over pixels.

    Args:
        points: (..., 2) rows and columns in the unit square.
        size: height and width in pixels.
        sigma: standard deviation in pixels; pixels farther than three of them along an axis get nothing.

    Returns:
        (..., size, size) that sum to one; a point outside the square counts as at its nearest pixel.
    """
    centres = torch.arange(size, device=points.device, dtype=points.dtype) + 0.5
    offset = centres - (points * size).clamp(0.5, size - 0.5)[..., None]  # (..., 2, size)
    weight = torch.exp(-0.5 * (offset / sigma) ** 2) * (offset.abs() <= max(3 * sigma, 0.5))
    weight = weight / weight.sum(dim=-1, keepdim=True)
    return weight[..., 0, :, None] * weight[..., 1, None, :]


def shrinking_sigma(step: int, start: float, end: float, steps: int) -> float:
    """Standard deviation in pixels at a training step: from start to end linearly over steps, then constant."""
    return end + (start - end) * max(0.0, 1.0 - step / max(steps, 1))
