"""The network of our own design, ``small``: rendered views and words to a heatmap for each view.

A convolutional U-net that shares its weights between the views, with a transformer over the coarsest tokens of all
views and the words (RVT's joint attention). Every block is modulated by the text: which thing is meant then needs no
attention to be found.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from lerobot_llakey.policies.action.networks.blocks import ConvBlock, Down, Film, TokenBlock, Up
from lerobot_llakey.policies.action.networks.view_network import ViewNetwork, ViewOutput


class MultiViewNetwork(ViewNetwork):
    """Views (B, V, S, S, C) to heatmaps.

    Args:
        channels: of a rendered pixel that depend on the scene alone.
        matches: channels that tell how well a pixel's colour fits the words.
        views: number of views.
        size: height and width of a view in pixels, a multiple of 16.
        condition: width of the condition vector.
        text_width: width of the word vectors.
        widths: channels at 1/4, 1/8 and 1/16.
        blocks: convolutional blocks at 1/4 and 1/8 on the way down.
        layers, heads: of the transformer at 1/16.
    """

    def __init__(
        self,
        channels: int,
        matches: int,
        views: int,
        size: int,
        condition: int,
        text_width: int,
        widths: Sequence[int],
        blocks: Sequence[int],
        layers: int,
        heads: int,
    ) -> None:
        super().__init__()
        fine, middle, coarse = widths
        # Apart, because the scene's channels need no gradient.
        self.stem, self.match_stem = Down(channels, fine, 4), Down(matches, fine, 4)
        self.view_bias = nn.Parameter(torch.zeros(views, 1, 1, fine))
        self.fine = nn.ModuleList(ConvBlock(fine, condition) for _ in range(blocks[0]))
        self.to_middle = Down(fine, middle)
        self.middle = nn.ModuleList(ConvBlock(middle, condition) for _ in range(blocks[1]))
        self.to_coarse = Down(middle, coarse)
        self.positions = nn.Parameter(torch.randn(views, size // 16, size // 16, coarse) * 0.1)
        self.words = nn.Linear(text_width, coarse)
        self.tokens = nn.ModuleList(TokenBlock(coarse, heads, condition) for _ in range(layers))
        self.from_coarse, self.middle_up = Up(coarse, middle), ConvBlock(middle, condition)
        self.from_middle, self.fine_up = Up(middle, fine), ConvBlock(fine, condition)
        self.head_norm, self.head_film = nn.LayerNorm(fine), Film(condition, fine)
        self.head = Up(fine, 1, 4)
        # A short way from colour to score: which colour a word means is learned through it within a few hundred steps.
        self.match_head = nn.Linear(matches, 1)
        self.feature_width, self.summary_width = fine, coarse

    def forward(
        self, images: Tensor, matches: Tensor | None, condition: Tensor, words: Tensor, padding: Tensor
    ) -> ViewOutput:
        assert matches is not None  # the design asks its stage for them
        fine = self.stem(images) + self.match_stem(matches)
        fine = fine + self.view_bias.to(fine.dtype)
        for block in self.fine:
            fine = block(fine, condition)
        middle = self.to_middle(fine)
        for block in self.middle:
            middle = block(middle, condition)
        coarse = self.to_coarse(middle)
        coarse = coarse + self.positions.to(coarse.dtype)
        grid = coarse.shape[1:4]
        seen = coarse.flatten(1, 3)
        tokens = torch.cat((seen, self.words(words).to(seen.dtype)), dim=1)
        mask = torch.zeros_like(tokens[..., 0])
        mask[:, seen.shape[1] :].masked_fill_(padding, float("-inf"))
        for block in self.tokens:
            tokens = block(tokens, condition, mask[:, None, None])
        seen = tokens[:, : seen.shape[1]]
        summary = seen.mean(dim=1)
        middle = self.middle_up(middle + self.from_coarse(seen.unflatten(1, grid)), condition)
        fine = self.fine_up(fine + self.from_middle(middle), condition)
        fine = self.head_norm(fine)
        # In float32 always: places are read off the logits to a part of a pixel, and it costs next to nothing.
        with torch.autocast(fine.device.type, enabled=False):
            heatmap = self.head(self.head_film(fine.float(), condition.float())) + self.match_head(matches.float())
        return ViewOutput(heatmap.squeeze(-1), fine, summary)
