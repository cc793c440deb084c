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
    "back": (2, 1, 0, False),
    "left": (2, 0, 1, True),
    "side": (2, 0, 1, False),
}
"""Name -> (axis of the rows, axis of the columns, depth axis, whether the greatest coordinate is nearest)."""

_DEPTH_STEPS = 2**15 - 1
_INDEX_BITS = 40


def splat(points: Tensor, rows: Tensor, batch: int, views: Sequence[str], size: int, radius: int = 0) -> Tensor:
    """Which point each pixel of each view shows.

    Args:
        points: (M, 3) coordinates in the unit cube; those outside it are not drawn.
        rows: (M,) int64 batch row that each point is drawn in.
        batch: number of rows B.
        views: names out of :data:`VIEWS`.
        size: height and width in pixels; pixel i spans [i, i + 1) / size.
        radius: points cover a square of 2 * radius + 1 pixels.

    Returns:
        (B, V, size, size) int64 index into the points of the nearest one, -1 where nothing is seen.
    """
    x, y, z = points.unbind(-1)
    drawn = (x >= 0) & (x < 1) & (y >= 0) & (y < 1) & (z >= 0) & (z < 1)
    order = drawn.nonzero().squeeze(1)
    points = points[order]
    cells = (points * size).long().clamp_(0, size - 1).unbind(-1)
    depths = (points * _DEPTH_STEPS).long().unbind(-1)
    offset = rows[order] * (size * size)
    far = torch.iinfo(torch.int64).max
    images = []
    for name in views:
        row, column, depth, greatest = VIEWS[name]
        nearness = _DEPTH_STEPS - depths[depth] if greatest else depths[depth]
        pixel = offset + cells[row] * size + cells[column]
        image = order.new_full((batch * size * size,), far)
        images.append(image.scatter_reduce_(0, pixel, (nearness << _INDEX_BITS) | order, "amin"))
    buffer = torch.stack([image.view(batch, size, size) for image in images], dim=1)
    for axis in (2, 3):
        for _ in range(radius):
            buffer = _spread(buffer, axis)
    return torch.where(buffer == far, -1, buffer & ((1 << _INDEX_BITS) - 1))


def _spread(buffer: Tensor, axis: int) -> Tensor:
    length = buffer.shape[axis] - 1
    spread = buffer.clone()
    low, high = spread.narrow(axis, 0, length), spread.narrow(axis, 1, length)
    torch.minimum(low, buffer.narrow(axis, 1, length), out=low)
    torch.minimum(high, buffer.narrow(axis, 0, length), out=high)
    return spread


def gather_pixels(values: Tensor, index: Tensor) -> Tensor:
    """Values (..., C) of points (M, C) at the pixels of an index (...); zero where nothing is seen."""
    if len(values) == 0:
        return values.new_zeros(*index.shape, values.shape[1])
    picked = values.index_select(0, index.flatten().clamp(min=0)).view(*index.shape, -1)
    return picked * (index >= 0)[..., None]


def project(points: Tensor, views: Sequence[str]) -> Tensor:
    """Rows and columns (..., V, 2) in the unit square of points (..., 3) in the unit cube."""
    return torch.stack([points[..., list(VIEWS[name][:2])] for name in views], dim=-2)
