"""Text-conditioned colour channels: how well each pixel's colour fits the words, at full resolution and almost free.

A table over a lattice of colours is filled for each text by a product of colour and word features; pixels only look
their colour up. Which colour a word means is thus learned in one multiplicative step, before any spatial reasoning.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from lerobot_llakey.policies.action.text.word_encoder import QueryPool

LEVELS = 16


def colour_index(colours: Tensor) -> Tensor:
    """Lattice index (...) int64 of colours (..., 3) in 0..1."""
    levels = (colours.clamp(0.0, 1.0) * (LEVELS - 1)).round().long()
    return (levels[..., 0] * LEVELS + levels[..., 1]) * LEVELS + levels[..., 2]


def _lattice() -> Tensor:
    axis = torch.linspace(0.0, 1.0, LEVELS)
    colours = torch.cartesian_prod(axis, axis, axis)  # (LEVELS^3, 3)
    brightness = colours.amax(dim=1, keepdim=True)
    # Shading scales a colour: its direction survives, so it is offered beside the colour itself.
    return torch.cat((colours, colours / brightness.clamp(min=0.1), brightness), dim=1)


class ColourGrounding(nn.Module):
    """Score each colour of the lattice for each of a few queries made from the words."""

    lattice: Tensor

    def __init__(self, text_width: int, queries: int, width: int = 64) -> None:
        super().__init__()
        self.register_buffer("lattice", _lattice(), persistent=False)
        self.colours = nn.Sequential(nn.Linear(7, width), nn.GELU(), nn.Linear(width, width), nn.LayerNorm(width))
        self.words = QueryPool(text_width, queries, width)
        self.scale = width**-0.5

    def forward(self, words: Tensor, padding: Tensor) -> Tensor:
        """Tables (B, LEVELS ** 3, queries) for word vectors (B, T, text_width) and their padding (B, T)."""
        queries = self.words(words, padding)
        return (self.colours(self.lattice) @ queries.transpose(1, 2)) * self.scale
