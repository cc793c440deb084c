"""The cube that all places are told in: the workspace's longest edge is one unit along every axis."""

from __future__ import annotations

from collections.abc import Sequence


def cube_around(workspace: Sequence[Sequence[float]]) -> tuple[tuple[float, ...], float]:
    """The cube around the middle of a workspace that its longest edge just fits in.

    One scale for all three axes: a pixel is as long one way as the other, turns stay turns, and a crop is a cube. What
    of the cube lies outside the workspace stays empty.

    Args:
        workspace: bounds (low, high) of x, y and z in metres.

    Returns:
        The lower corner and the edge, in metres.
    """
    edge = max(high - low for low, high in workspace)
    return tuple((low + high) / 2 - edge / 2 for low, high in workspace), edge
