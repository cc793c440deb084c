"""From heat maps to a point, and from the features at that point to rotation, gripper and collision flag."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Tensor, nn

from lerobot_llakey.policies.action.renderer import VIEWS, project


def locate(heat: Tensor, views: Sequence[str]) -> Tensor:
    """The point of the unit cube whose projections are together most likely.

    Every cell of the grid is scored by the sum of its log-probabilities in all views (RVT's back-projection, here a
    sum of broadcast planes as the views are axis-aligned), and a parabola through the best cell's neighbours refines
    each axis.

    Args:
        heat: (B, V, S, S) logits.
        views: the V names.

    Returns:
        (B, 3) coordinates in the unit cube.
    """
    size = heat.shape[-1]
    logs = heat.flatten(2).log_softmax(dim=-1).unflatten(2, (size, size))
    score = logs.new_zeros(heat.shape[0], 1, 1, 1)
    for view, name in enumerate(views):
        row, column, depth, _ = VIEWS[name]
        plane = logs[:, view] if row < column else logs[:, view].transpose(1, 2)
        score = score + plane.unsqueeze(depth + 1)
    shape = score.shape[1:]
    best = torch.stack(torch.unravel_index(score.flatten(1).argmax(dim=1), shape), dim=-1)  # (B, 3)
    rows = torch.arange(heat.shape[0], device=heat.device)
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


def features_at(features: Tensor, points: Tensor, views: Sequence[str]) -> Tensor:
    """Bilinear features (B, V * C) at the projections of points (B, 3) of the unit cube; features (B, V, H, W, C)."""
    spots = project(points, views).flip(-1) * 2 - 1  # grid_sample wants x (columns) first
    maps = features.flatten(0, 1).permute(0, 3, 1, 2)
    grid = spots.flatten(0, 1)[:, None, None].to(maps.dtype)
    picked = nn.functional.grid_sample(maps, grid, padding_mode="border", align_corners=False)
    return picked.flatten(1).unflatten(0, features.shape[:2]).flatten(1)


def shift_bins(logits: Tensor, angles: Tensor) -> Tensor:
    """Logits (..., bins) of angles relative to a present angle (...) in radians, as logits of absolute angles."""
    bins = logits.shape[-1]
    offset = angles * (bins / (2 * math.pi))
    whole = offset.floor()
    share = (offset - whole)[..., None]
    source = (torch.arange(bins, device=logits.device) - whole[..., None].long()) % bins
    return (1 - share) * logits.gather(-1, source) + share * logits.gather(-1, (source - 1) % bins)


class PoseHead(nn.Module):
    """Logits of three angles, the gripper and the collision flag.

    Angles are the sum of three votes: in the frame of the views ("grasp it along its side"), relative to the present
    hand ("a quarter turn on", "keep it") and relative to the robot's base, which augmentation turns ("straight ahead").
    No kind of instruction then has to learn to add angles, and what is fixed in the base frame survives augmentation.

    Args:
        inputs: width of the input vector.
        bins: of each angle.
        width: of the hidden layer.
    """

    def __init__(self, inputs: int, bins: int, width: int = 256) -> None:
        super().__init__()
        self.bins = bins
        self.layers = nn.Sequential(
            nn.LayerNorm(inputs), nn.Linear(inputs, width), nn.GELU(), nn.Linear(width, width), nn.GELU()
        )
        self.votes = nn.Linear(width, 9 * bins)
        self.flags = nn.Linear(width, 4)

    def forward(self, features: Tensor, present: Tensor, heading: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Read a pose.

        Args:
            features: (B, inputs).
            present: (B, 3) the hand's present angles in radians.
            heading: (B,) yaw of the robot's base in radians: zero but for augmentation.

        Returns:
            Logits of the angles (B, 3, bins), the gripper (B, 2) and the collision flag (B, 2).
        """
        hidden = self.layers(features)
        flags = self.flags(hidden).float()
        seen, hand, base = self.votes(hidden).float().unflatten(-1, (3, 3, self.bins)).unbind(1)
        turn = torch.stack((heading, torch.zeros_like(heading), torch.zeros_like(heading)), dim=-1)
        return seen + shift_bins(hand, present) + shift_bins(base, turn), flags[:, :2], flags[:, 2:]
