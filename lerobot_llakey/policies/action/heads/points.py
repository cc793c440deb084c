"""From heatmaps to a point, and to the features that the pose is read from."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from lerobot_llakey.policies.action.networks.view_network import ViewOutput
from lerobot_llakey.policies.action.views.renderer import VIEWS, project


def locate(heatmap: Tensor, views: Sequence[str]) -> Tensor:
    """The point of the unit cube whose projections are together most likely.

    Every cell of the grid is scored by the sum of its log-probabilities in all views (RVT's back-projection, here a
    sum of broadcast planes as the views are axis-aligned), and a parabola through the best cell's neighbours refines
    each axis.

    Args:
        heatmap: (B, V, S, S) logits.
        views: the V names.

    Returns:
        (B, 3) coordinates in the unit cube.
    """
    size = heatmap.shape[-1]
    logs = heatmap.flatten(2).log_softmax(dim=-1).unflatten(2, (size, size))
    score = logs.new_zeros(heatmap.shape[0], 1, 1, 1)
    for view, name in enumerate(views):
        row, column, depth, _ = VIEWS[name]
        plane = logs[:, view] if row < column else logs[:, view].transpose(1, 2)
        plane = plane.unsqueeze(depth + 1)
        # In place once it is whole: it has half a million cells.
        score = score.add_(plane) if score.shape[1:] == (size, size, size) else score + plane
    rows = torch.arange(heatmap.shape[0], device=heatmap.device)
    # The greatest of each line first: a search for its place as well takes ten times as long.
    line = score.amax(dim=3).flatten(1).argmax(dim=1)
    first, second = line // size, line % size
    best = torch.stack((first, second, score[rows, first, second].argmax(dim=1)), dim=-1)  # (B, 3)
    refined = []
    for axis in range(3):
        around = []
        for step in (-1, 0, 1):
            cell = best.clone()
            cell[:, axis] = (cell[:, axis] + step).clamp(0, size - 1)
            around.append(score[rows, cell[:, 0], cell[:, 1], cell[:, 2]])
        low, middle, high = around
        bend = (low + high - 2 * middle).clamp(max=-1e-6)
        refined.append(best[:, axis] + 0.5 + (0.5 * (low - high) / bend).clamp(-0.5, 0.5))
    return torch.stack(refined, dim=-1) / size


def with_prior(heatmap: Tensor, coarse: Tensor, low: Tensor, extent: float, views: Sequence[str]) -> Tensor:
    """A zoomed stage's logits, plus the log-probabilities of the stage before at the same places.

    The zoomed stage is trained on cubes that lie anywhere near the target, so alone its prior
    over the cube is uniform. High above a target the cube may show nothing but air: then the first stage decides.
    Where the zoomed stage is certain, it is sharper by the zoom factor and the prior hardly moves its peak.

    Args:
        heatmap: (B, V, S, S) logits of the zoomed stage.
        coarse: (B, V, S, S) logits of the first stage, over the unit cube.
        low: (B, 3) lower corner of the zoomed cube in the unit cube.
        extent: its edge.
        views: the V names.

    Returns:
        (B, V, S, S) logits.
    """
    size = heatmap.shape[-1]
    steps = (torch.arange(size, device=heatmap.device) + 0.5) / size * extent
    corner = project(low, views)  # (B, V, 2)
    rows, columns = (corner[..., axis, None] + steps for axis in (0, 1))
    grid = torch.stack(
        (columns[..., None, :].expand(*heatmap.shape), rows[..., None].expand(*heatmap.shape)), dim=-1
    )  # (B, V, S, S, 2), columns first
    logs = coarse.flatten(2).log_softmax(dim=-1).unflatten(2, coarse.shape[2:])
    prior = nn.functional.grid_sample(
        logs.flatten(0, 1)[:, None], grid.flatten(0, 1) * 2 - 1, "bicubic", "border", align_corners=False
    )
    return heatmap.flatten(2).log_softmax(dim=-1).unflatten(2, (size, size)) + prior.view_as(heatmap)


def features_at(features: Tensor, points: Tensor, views: Sequence[str]) -> Tensor:
    """Bilinear features (B, V * C) at the projections of points (B, 3) of the unit cube; features (B, V, H, W, C)."""
    positions = project(points, views).flip(-1) * 2 - 1  # grid_sample wants x (columns) first
    maps = features.flatten(0, 1).permute(0, 3, 1, 2)
    grid = positions.flatten(0, 1)[:, None, None].to(maps.dtype)
    picked = nn.functional.grid_sample(maps, grid, padding_mode="border", align_corners=False)
    return picked.flatten(1).unflatten(0, features.shape[:2]).flatten(1)


def pooled_at(output: ViewOutput, points: Tensor, views: Sequence[str]) -> Tensor:
    """Features (B, V * C) at points (B, 3) of the unit cube (RVT-2's location-conditioned features)."""
    return features_at(output.features, points, views)


def heatmap_weighted(output: ViewOutput, points: Tensor, views: Sequence[str]) -> Tensor:
    """Features (B, V * C) of each view's pixels, weighted by its heatmap (RVT); it ignores the points."""
    share = output.heatmap.detach().flatten(2).softmax(dim=-1).to(output.features.dtype)  # (B, V, S * S)
    return (share[:, :, None] @ output.features.flatten(2, 3)).flatten(1)
