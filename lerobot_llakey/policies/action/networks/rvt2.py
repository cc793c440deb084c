"""The network of RVT-2 (Goyal et al., "RVT-2: Learning Precise Manipulation from Few Demonstrations", RSS 2024)."""

from __future__ import annotations

from torch import Tensor

from lerobot_llakey.policies.action.networks.blocks import Down
from lerobot_llakey.policies.action.networks.joint_transformer import (
    PATCH_CHANNELS,
    GroupedActivation,
    JointTransformer,
)
from lerobot_llakey.policies.action.networks.upsampling import ConvexUpsampling
from lerobot_llakey.policies.action.networks.view_network import ViewNetwork, ViewOutput


class Rvt2Network(ViewNetwork):
    """Patches through the joint transformer, whose tokens are the features; the heatmap is a convex upsampling.

    There are no layers at full resolution. As published: 3 views of 224 pixels, patch 14, 8 layers of width 512 with 8
    heads, two stages. Arguments as for :class:`rvt.RvtNetwork`.
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
        self.patches = Down(channels, PATCH_CHANNELS, patch)
        self.patches_activation = GroupedActivation(PATCH_CHANNELS)
        self.transformer = JointTransformer(views, size // patch, condition, text_width, width, layers, heads, dropout)
        tokens = self.transformer.channels
        self.heatmap = ConvexUpsampling(tokens, patch)
        self.feature_width, self.summary_width = tokens, views * tokens

    def forward(
        self, images: Tensor, matches: Tensor | None, condition: Tensor, words: Tensor, padding: Tensor
    ) -> ViewOutput:
        patches = self.patches_activation(self.patches(images).flatten(0, 1)).unflatten(0, images.shape[:2])
        tokens = self.transformer(patches, condition, words, padding)
        summary = tokens.flatten(2, 3).amax(dim=2).flatten(1)
        heatmap = self.heatmap(tokens.flatten(0, 1).permute(0, 3, 1, 2)).unflatten(0, images.shape[:2])
        return ViewOutput(heatmap.float(), tokens, summary)
