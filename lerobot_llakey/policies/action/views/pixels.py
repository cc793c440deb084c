"""The channels of a rendered pixel: one function for each layout."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import torch
from torch import Tensor

from lerobot_llakey.policies.action.views.renderer import VIEWS, gather_pixels, project
from lerobot_llakey.policies.action.views.scene import Scene

GROUNDED_CHANNELS = 9
"""Red, green, blue, seen, depth in the cube, absolute depth, row and column, and the present end effector."""
PLAIN_CHANNELS = 10
"""Position in the cube (x, y, z), red, green, blue, depth in the cube, and which view, row and column it is."""
MARKER_SIGMA = 0.02
"""Width of the end effector's mark, as a share of the view."""

Painter = Callable[[Scene, Tensor, Tensor, float, Sequence[str], torch.dtype], Tensor]
"""(scene, index (B, V, S, S) of :func:`renderer.splat`, low (B, 3), extent, views, dtype) -> (B, V, S, S, C)."""


def grounded_pixels(
    scene: Scene, index: Tensor, low: Tensor, extent: float, views: Sequence[str], dtype: torch.dtype
) -> Tensor:
    """Channels (B, V, S, S, GROUNDED_CHANNELS) of our own design; positions are centred on zero.

    Args:
        scene: to render.
        index: (B, V, S, S) the point that each pixel shows, -1 for none.
        low: (B, 3) lower corner of the rendered cube, in workspace units.
        extent: its edge, in workspace units.
        views: the V names.
        dtype: of the result.
    """
    size = index.shape[-1]
    axis = (torch.arange(size, device=low.device) + 0.5) / size
    # Beyond the view the mark fades; without the hand's pose its position is NaN and nothing shows.
    effector = project((scene.effector - low) / extent, views)  # (B, V, 2)
    bumps = torch.exp(-0.5 * ((axis - effector[..., None]) / MARKER_SIGMA) ** 2).nan_to_num(0.0).to(dtype)
    images = low.new_empty(*index.shape, GROUNDED_CHANNELS, dtype=dtype)
    images[..., :3] = gather_pixels(scene.colours, index)
    images[..., 3] = seen = index >= 0
    base = scene.base * scene.base.new_tensor((0.0, 0.0, 1.0)) + 0.5
    for view, name in enumerate(views):
        row, column, depth, _ = VIEWS[name]
        away = gather_pixels(scene.points[:, depth, None], index[:, view]).squeeze(-1)
        images[:, view, ..., 4] = ((away - low[:, depth, None, None]) / extent - 0.5) * seen[:, view]
        images[:, view, ..., 5] = (away - base[:, depth, None, None]) * seen[:, view]
        images[:, view, ..., 6] = (low[:, row, None] + axis * extent - base[:, row, None])[:, :, None]
        images[:, view, ..., 7] = (low[:, column, None] + axis * extent - base[:, column, None])[:, None, :]
    images[..., 8] = bumps[..., 0, :, None] * bumps[..., 1, None, :]
    return images


def plain_pixels(
    scene: Scene, index: Tensor, low: Tensor, extent: float, views: Sequence[str], dtype: torch.dtype
) -> Tensor:
    """Channels (B, V, S, S, PLAIN_CHANNELS) of RVT and RVT-2, each in -1..1 and 0 where nothing is seen.

    Everything is relative to the rendered cube: a crop looks the same wherever it lies. Arguments as for
    :func:`grounded_pixels`.
    """
    size, count = index.shape[-1], len(views)
    images = low.new_empty(*index.shape, PLAIN_CHANNELS, dtype=dtype)
    local = (scene.points - low[scene.rows]) / extent
    shown = gather_pixels(torch.cat((local, scene.colours), dim=1) * 2 - 1, index)
    images[..., :6] = shown
    for view, name in enumerate(views):
        images[:, view, ..., 6] = shown[:, view, ..., VIEWS[name][2]]
    axis = torch.linspace(-1.0, 1.0, size, device=low.device)
    which = torch.linspace(-1.0, 1.0, count, device=low.device)
    images[..., 7] = which[:, None, None]
    images[..., 8] = axis[:, None]
    images[..., 9] = axis
    return images
