"""The transformer of RVT and RVT-2: attention within each view, then over all views and the words."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional as F

PATCH_CHANNELS = 64
"""Channels of a patch, and as many of the proprioception beside it."""
SLOPE = 0.02
"""Of the published designs' leaky rectifiers."""
_GROUPS = 4


class GatedBlock(nn.Module):
    """A pre-norm transformer layer with a gated feed-forward part, on (B, N, C) tokens.

    Args:
        width: C.
        heads: of the attention, which divide the width.
        dropout: share of the attention's weights that are dropped in training.
    """

    def __init__(self, width: int, heads: int, dropout: float) -> None:
        super().__init__()
        self.heads, self.dropout = heads, dropout
        self.attention_norm, self.hidden_norm = nn.LayerNorm(width), nn.LayerNorm(width)
        self.qkv, self.merge = nn.Linear(width, 3 * width, bias=False), nn.Linear(width, width)
        self.hidden, self.out = nn.Linear(width, 8 * width), nn.Linear(4 * width, width)

    def forward(self, tokens: Tensor, mask: Tensor | None = None) -> Tensor:
        """Tokens (B, N, C); mask (B, 1, 1, N) bool is true at tokens that may be looked at."""
        qkv = self.qkv(self.attention_norm(tokens)).unflatten(-1, (3, self.heads, -1)).permute(2, 0, 3, 1, 4)
        dropout = self.dropout if self.training else 0.0
        attended = F.scaled_dot_product_attention(qkv[0], qkv[1], qkv[2], attn_mask=mask, dropout_p=dropout)
        tokens = tokens + self.merge(attended.transpose(1, 2).flatten(2))
        value, gate = self.hidden(self.hidden_norm(tokens)).chunk(2, dim=-1)
        return tokens + self.out(value * F.gelu(gate))


class GroupedActivation(nn.Module):
    """Group normalisation over channels and the grid, then a leaky rectifier, on (N, ..., C)."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.norm = nn.GroupNorm(_GROUPS, channels)

    def forward(self, features: Tensor) -> Tensor:
        return F.leaky_relu(self.norm(features.movedim(-1, 1)), SLOPE).movedim(1, -1)


class JointTransformer(nn.Module):
    """Patches of all views, proprioception and words to features of the patches.

    Args:
        views: number of views V.
        grid: patches along an edge of a view.
        condition: width of the proprioception.
        text_width: width of the word vectors.
        width: of the tokens; layers and heads: of the transformer; dropout: of its attention.
    """

    def __init__(
        self,
        views: int,
        grid: int,
        condition: int,
        text_width: int,
        width: int,
        layers: int,
        heads: int,
        dropout: float,
    ) -> None:
        super().__init__()
        self.channels = channels = 2 * PATCH_CHANNELS
        self.proprioception = nn.Linear(condition, PATCH_CHANNELS)
        self.proprioception_activation = GroupedActivation(PATCH_CHANNELS)
        self.words, self.words_activation = nn.Linear(text_width, channels), GroupedActivation(channels)
        self.positions = nn.Parameter(torch.randn(views, grid, grid, channels))
        self.widen, self.narrow = nn.Linear(channels, width), nn.Linear(width, channels)
        self.layers = nn.ModuleList(GatedBlock(width, heads, dropout) for _ in range(layers))

    def forward(self, patches: Tensor, condition: Tensor, words: Tensor, padding: Tensor) -> Tensor:
        """Mix views, words and proprioception.

        Args:
            patches: (B, V, h, w, PATCH_CHANNELS).
            condition: (B, D) proprioception.
            words: (B, T, W) word vectors.
            padding: (B, T) bool, true where there is no word.

        Returns:
            (B, V, h, w, 2 * PATCH_CHANNELS).
        """
        batch, views, height, width = patches.shape[:4]
        hand = self.proprioception_activation(self.proprioception(condition))[:, None, None, None]
        hand = hand.to(patches.dtype).expand(*patches.shape[:-1], -1)
        tokens = torch.cat((patches, hand), dim=-1)
        tokens = self.widen(tokens + self.positions.to(tokens.dtype)).flatten(0, 1).flatten(1, 2)  # (B*V, h*w, C)
        half = len(self.layers) // 2
        for layer in self.layers[:half]:
            tokens = layer(tokens)
        # Each word is normalised by itself: how many stand beside it must not matter.
        said = self.words_activation(self.words(words).flatten(0, 1)).unflatten(0, words.shape[:2])
        said = self.widen(said)
        count = views * height * width
        tokens = torch.cat((tokens.reshape(batch, count, -1), said.to(tokens.dtype)), dim=1)
        mask = F.pad(~padding, (count, 0), value=True)[:, None, None]
        for layer in self.layers[half:]:
            tokens = layer(tokens, mask)
        return self.narrow(tokens[:, :count]).unflatten(1, (views, height, width))
