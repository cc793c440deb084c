"""Targets of the classification losses: heatmaps (LLaKey section III-D, RVT) and angle bins (PerAct).

Rotations are read as R = Rz(a) Ry(b) Rx(c) R_ref, where R_ref points the hand halfway between straight down and
straight ahead. Its singular directions (b = +-90 degrees) are then 45 degrees away from both the grasp from above and
any level approach, and turning the scene about z only shifts a.

No three angles are smooth over all rotations. Next to a singular direction only one of a + c and a - c means anything,
and the least jitter moves both by any amount: there the labels go over to c = 0, see :func:`rotation_target`.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor
from torch.nn import functional as F

from lerobot_llakey import geometry

_HALF = math.sqrt(0.5)
# Columns are the hand's axes in the base frame; z of the hand points ahead (x) and down.
_REFERENCE = ((_HALF, 0.0, _HALF), (0.0, -1.0, 0.0), (_HALF, 0.0, -_HALF))


def quaternion_to_angles(quaternion: Tensor) -> Tensor:
    """Angles (..., 3) = (a, b, c) in radians of unit quaternions (..., 4) xyzw; b within +-pi/2."""
    matrix = _from_reference(quaternion)
    a = torch.atan2(matrix[..., 1, 0], matrix[..., 0, 0])
    b = torch.asin((-matrix[..., 2, 0]).clamp(-1.0, 1.0))
    c = torch.atan2(matrix[..., 2, 1], matrix[..., 2, 2])
    return torch.stack((a, b, c), dim=-1)


def _from_reference(quaternion: Tensor) -> Tensor:
    """Rotation matrices (..., 3, 3) that take R_ref to unit quaternions (..., 4) xyzw."""
    return geometry.quaternion_to_matrix(quaternion) @ quaternion.new_tensor(_REFERENCE).T


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


def rotation_target(quaternion: Tensor, bins: int) -> Tensor:
    """Which bins the angles of unit quaternions (..., 4) lie in, as probabilities (..., 3, bins): nearly always 0 or 1.

    Within half a bin of a singular direction every split between a and c decodes to the same rotation. The labels
    there go over from the angles' own bins, at the border, to those of a alone with c = 0, at the singular
    direction itself. So they change little where the rotation does: jitter moves no label far.
    """
    angles = quaternion_to_angles(quaternion)
    matrix = _from_reference(quaternion)
    whole = torch.atan2(-matrix[..., 0, 1], matrix[..., 1, 1])
    singular = torch.stack((whole, angles[..., 1], torch.zeros_like(whole)), dim=-1)
    own, other = (F.one_hot(angle_bins(kind, bins), bins).to(quaternion) for kind in (angles, singular))
    share = ((math.pi / 2 - angles[..., 1].abs()) * (bins / math.pi)).clamp(0.0, 1.0)[..., None, None]
    return share * own + (1 - share) * other


def bin_angles(index: Tensor, bins: int) -> Tensor:
    """Angle in radians, in (-pi, pi], at the centre of bins."""
    angles = index * (2 * math.pi / bins)
    return torch.where(angles > math.pi, angles - 2 * math.pi, angles)


def heatmap_target(points: Tensor, size: int, sigma: float) -> Tensor:
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
