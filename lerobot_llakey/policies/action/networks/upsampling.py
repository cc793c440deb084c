"""Convex upsampling: a coarse map made fine without layers at full resolution."""

from __future__ import annotations

from torch import Tensor, nn
from torch.nn import functional as F

_NEIGHBOURS = 9
_CALM = 0.1
"""Factor on the weights' logits, so that every neighbour counts at first (RAFT's 0.25, RVT-2's 0.1)."""


class ConvexUpsampling(nn.Module):
    """Each fine pixel is a learned weighted mean of the 3x3 coarse values around it (Teed and Deng, RAFT, 2020).

    Args:
        channels: of the coarse features.
        factor: fine pixels along the edge of a coarse one.
    """

    def __init__(self, channels: int, factor: int) -> None:
        super().__init__()
        self.factor, hidden = factor, 2 * channels
        self.values = nn.Sequential(
            nn.Conv2d(channels, hidden, 3, padding=1),
            nn.ReLU(),
            nn.Conv2d(hidden, hidden, 3, padding=1),
            nn.ReLU(),
            nn.Conv2d(hidden, 1, 3, padding=1),
        )
        self.weights = nn.Sequential(
            nn.Conv2d(channels, hidden, 3, padding=1), nn.ReLU(), nn.Conv2d(hidden, _NEIGHBOURS * factor**2, 1)
        )

    def forward(self, features: Tensor) -> Tensor:
        """Features (N, C, h, w) to a map (N, h * factor, w * factor)."""
        height, width = features.shape[2:]
        around = F.unfold(self.values(features).float(), 3, padding=1).view(-1, _NEIGHBOURS, 1, 1, height, width)
        logits = self.weights(features).float().view(-1, _NEIGHBOURS, self.factor, self.factor, height, width)
        fine = ((_CALM * logits).softmax(dim=1) * around).sum(dim=1)  # (N, k, k, h, w)
        return fine.permute(0, 3, 1, 4, 2).flatten(3, 4).flatten(1, 2)
