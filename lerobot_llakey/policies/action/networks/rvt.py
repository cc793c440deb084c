"""The network of RVT (Goyal et al., "RVT: Robotic View Transformer for 3D Object Manipulation", CoRL 2023)."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from lerobot_llakey.policies.action.networks.blocks import Down
from lerobot_llakey.policies.action.networks.joint_transformer import (
    PATCH_CHANNELS,
    SLOPE,
    GroupedActivation,
    JointTransformer,
)
from lerobot_llakey.policies.action.networks.view_network import ViewNetwork, ViewOutput


def _convolution(inputs: int, outputs: int, kernel: int) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, kernel, padding=kernel // 2, padding_mode="replicate")


class RvtNetwork(ViewNetwork):
    """Patches through the joint transformer, upsampled to full resolution beside the early pixel features.

    Features are those of every pixel, the summary is the maximum of each view's tokens: with the former weighted by
    the heatmap they are RVT's global features. As published: 5 views of 220 pixels, patch 11, 8 layers of width 512
    with 8 heads.

    Args:
        channels: of a rendered pixel.
        views: number of views V.
        size: height and width of a view in pixels, a multiple of the patch.
        patch: edge of a patch in pixels.
        condition: width of the proprioception.
        text_width: width of the word vectors.
        width, layers, heads, dropout: of the transformer.
    """

    def __init__(
        self,
        channels: int,
        views: int,
        size: int,
        patch: int,
        condition: int,
        text_width: int,
        width: int,
        layers: int,
        heads: int,
        dropout: float = 0.0,
    ) -> None:
        super().__init__()
        hidden = PATCH_CHANNELS
        self.pixels = nn.Linear(channels, hidden)
        self.patches, self.patches_activation = Down(hidden, hidden, patch), GroupedActivation(hidden)
        self.transformer = JointTransformer(views, size // patch, condition, text_width, width, layers, heads, dropout)
        tokens = self.transformer.channels
        kernel = patch | 1  # as wide as a patch, and odd
        self.before_up, self.after_up = _convolution(tokens, hidden, kernel), _convolution(hidden, hidden, kernel)
        self.join, self.heatmap = _convolution(2 * hidden, hidden, 3), _convolution(hidden, 1, 3)
        self.feature_width, self.summary_width = hidden, views * tokens

    def forward(
        self, images: Tensor, matches: Tensor | None, condition: Tensor, words: Tensor, padding: Tensor
    ) -> ViewOutput:
        early = F.leaky_relu(self.pixels(images), SLOPE)  # (B, V, S, S, C)
        patches = self.patches_activation(self.patches(early).flatten(0, 1)).unflatten(0, images.shape[:2])
        tokens = self.transformer(patches, condition, words, padding)
        summary = tokens.flatten(2, 3).amax(dim=2).flatten(1)
        maps = tokens.flatten(0, 1).permute(0, 3, 1, 2)
        maps = F.leaky_relu(self.before_up(maps), SLOPE)
        maps = F.interpolate(maps, size=images.shape[2:4], mode="bilinear")
        maps = F.leaky_relu(self.after_up(maps), SLOPE)
        maps = torch.cat((maps, early.flatten(0, 1).permute(0, 3, 1, 2).to(maps.dtype)), dim=1)
        maps = F.leaky_relu(self.join(maps), SLOPE)
        heatmap = self.heatmap(maps).squeeze(1).unflatten(0, images.shape[:2])
        features = maps.permute(0, 2, 3, 1).unflatten(0, images.shape[:2])
        return ViewOutput(heatmap.float(), features, summary)
