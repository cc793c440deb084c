"""The unit cube, in which all positions are expressed: the workspace's longest edge is one unit along every axis."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn


class UnitCube(nn.Module):
    """The cube around the middle of a workspace that its longest edge just fits in.

    One scale for all three axes: a pixel has the same length along each, rotations stay rotations, and a crop is a
    cube. The part of the cube outside the workspace stays empty.

    Args:
        workspace: bounds (low, high) of x, y and z in metres.

    Attributes:
        corner: (3,) its lower corner in metres.
        edge: its edge in metres.
    """

    corner: Tensor

    def __init__(self, workspace: Sequence[Sequence[float]]) -> None:
        super().__init__()
        self.edge = longest_edge(workspace)
        corner = [(low + high) / 2 - self.edge / 2 for low, high in workspace]
        self.register_buffer("corner", torch.tensor(corner, dtype=torch.float32), persistent=False)

    def to_unit(self, position: Tensor) -> Tensor:
        """Positions (..., 3) in metres, in units of the cube."""
        return (position - self.corner) / self.edge

    def from_unit(self, position: Tensor) -> Tensor:
        """Inverse of :meth:`to_unit`."""
        return position * self.edge + self.corner

    def crop(self, centre: Tensor, size: float) -> tuple[Tensor, float]:
        """Lower corner (..., 3) and edge, in units, of a cube of ``size`` metres around a centre (..., 3) in units."""
        extent = size / self.edge
        return centre - extent / 2, extent


def longest_edge(workspace: Sequence[Sequence[float]]) -> float:
    """The longest edge of a workspace in metres."""
    return max(high - low for low, high in workspace)
