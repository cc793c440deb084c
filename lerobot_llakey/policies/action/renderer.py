"""Render point clouds from virtual orthographic views by z-buffer splatting, in plain PyTorch.

RVT renders with PyTorch3D and RVT-2 with a CUDA kernel of its own. Here depth and point index share one integer, so
that a single scatter with minimum resolves visibility; points wider than a pixel come from a minimum over neighbours.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

VIEWS: dict[str, tuple[int, int, int, bool]] = {
    "top": (0, 1, 2, True),
    "front": (2, 1, 0, True),
    "side": (2, 0, 1, False),
    "back": (2, 1, 0, False),
    "left": (2, 0, 1, True),
}
"""Name -> (axis of the rows, axis of the columns, depth axis, whether the greatest coordinate is nearest)."""

_DEPTH_STEPS = 2**15 - 1


def splat(points: Tensor, valid: Tensor, views: Sequence[str], size: int, radius: int = 0) -> Tensor:
    """Which point each pixel of each view shows.

    Args:
        points: (B, N, 3) coordinates in the unit cube.
        valid: (B, N) bool; other points, and those outside the cube, are not drawn.
        views: names out of :data:`VIEWS`.
        size: height and width in pixels; pixel i spans [i, i + 1) / size.
        radius: points cover a square of 2 * radius + 1 pixels.

    Returns:
        (B, V, size, size) int64 index of the nearest point, -1 where nothing is seen.
    """
    batch, count, _ = points.shape
    valid = valid & ((points >= 0) & (points < 1)).all(dim=-1)
    points = torch.where(valid[..., None], points, 0.0)
    cells = (points * size).long().clamp_(0, size - 1)  # (B, N, 3)
    bits = max(count - 1, 1).bit_length()
    dtype = torch.int32 if bits <= 16 else torch.int64
    depths = (points * _DEPTH_STEPS).to(dtype)
    order = torch.arange(count, device=points.device, dtype=dtype)
    far = torch.iinfo(dtype).max
    plane = size * size
    images = []
    for name in views:
        row, column, depth, greatest = VIEWS[name]
        nearness = _DEPTH_STEPS - depths[..., depth] if greatest else depths[..., depth]
        key = torch.where(valid, (nearness << bits) | order, far)
        pixel = cells[..., row] * size + cells[..., column]
        images.append(key.new_full((batch, plane), far).scatter_reduce_(1, pixel, key, "amin"))
    buffer = torch.stack(images, dim=1).unflatten(2, (size, size))
    for axis in (2, 3):
        for _ in range(radius):
            buffer = _spread(buffer, axis)
    index = (buffer & ((1 << bits) - 1)).long()
    return torch.where(buffer == far, -1, index)


def _spread(buffer: Tensor, axis: int) -> Tensor:
    length = buffer.shape[axis] - 1
    spread = buffer.clone()
    low, high = spread.narrow(axis, 0, length), spread.narrow(axis, 1, length)
    torch.minimum(low, buffer.narrow(axis, 1, length), out=low)
    torch.minimum(high, buffer.narrow(axis, 0, length), out=high)
    return spread


def gather_pixels(values: Tensor, index: Tensor) -> Tensor:
    """Values (B, V, S, S, C) of points (B, N, C) at the pixels of an index (B, V, S, S); zero where nothing is seen."""
    flat = index.flatten(1).clamp(min=0)
    picked = values.gather(1, flat[..., None].expand(-1, -1, values.shape[-1])).unflatten(1, index.shape[1:])
    return picked * (index >= 0)[..., None]


def project(points: Tensor, views: Sequence[str]) -> Tensor:
    """Rows and columns (..., V, 2) in the unit square of points (..., 3) in the unit cube."""
    return torch.stack([points[..., list(VIEWS[name][:2])] for name in views], dim=-2)
