"""The parts of the training loss that concern heatmaps and flags, and how often they are right."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn import functional as F

from lerobot_llakey.geometry import rotation_error
from lerobot_llakey.policies.action.heads.targets import heatmap_target
from lerobot_llakey.policies.action.networks.view_network import ViewOutput
from lerobot_llakey.policies.action.views.renderer import project


def heatmap_loss(output: ViewOutput, point: Tensor, views: Sequence[str], sigma: float) -> Tensor:
    """Cross-entropy (B,) of the heatmaps against Gaussians around a point, averaged over the views.

    Args:
        output: of a stage.
        point: (B, 3) in the unit cube that the stage has rendered.
        views: names of the views.
        sigma: standard deviation of the Gaussians in pixels.
    """
    target = heatmap_target(project(point, views), output.heatmap.shape[-1], sigma)
    logs = output.heatmap.flatten(2).log_softmax(dim=-1)
    return -(target.flatten(2) * logs).sum(dim=-1).mean(dim=1)


def share_within(output: ViewOutput, point: Tensor, views: Sequence[str], distance: float) -> float:
    """Share of views whose hottest pixel lies within a distance (in units of the stage's cube) of a point (B, 3)."""
    size = output.heatmap.shape[-1]
    best = output.heatmap.detach().flatten(2).argmax(dim=-1)
    position = torch.stack((best // size, best % size), dim=-1).add(0.5) / size
    offset = (position - project(point, views)).norm(dim=-1)
    return (offset <= distance).float().mean().item()


def flag_loss(logits: Tensor, flag: Tensor) -> Tensor:
    """Cross-entropy (B,) of logits (B, 2) against a flag (B,) bool."""
    return F.cross_entropy(logits, flag.long(), reduction="none")


def share_right(logits: Tensor, flag: Tensor) -> float:
    """Share of rows whose logits (B, 2) favour the flag (B,) bool."""
    return (logits.argmax(dim=-1) == flag).float().mean().item()


def share_turned_less(first: Tensor, second: Tensor, degrees: float) -> float:
    """Share of rows in which two quaternions (B, 4) differ by at most some degrees, half a turn not counting."""
    return (rotation_error(first, second) <= degrees).float().mean().item()
