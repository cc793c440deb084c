"""The designs of the action policy, by name: what is particular to each; all else they share.

``small`` is ours, shipped and fast on a CPU; ``rvt`` (Goyal et al. 2023, the paper's action model) and ``rvt2`` (Goyal
et al. 2024) are the published ones. A new design is a network, and one entry here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from torch import Tensor

from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.action.heads.points import heatmap_weighted, pooled_at
from lerobot_llakey.policies.action.heads.pose_heads import BinsHead, PoseHead
from lerobot_llakey.policies.action.heads.rotation_sequential import SequentialBinsHead
from lerobot_llakey.policies.action.heads.rotation_sixd import SixDHead
from lerobot_llakey.policies.action.networks.rvt import RvtNetwork
from lerobot_llakey.policies.action.networks.rvt2 import Rvt2Network
from lerobot_llakey.policies.action.networks.small import MultiViewNetwork
from lerobot_llakey.policies.action.networks.view_network import ViewNetwork, ViewOutput
from lerobot_llakey.policies.action.text.hub_encoder import HubTextEncoder
from lerobot_llakey.policies.action.text.word_encoder import TextEncoder
from lerobot_llakey.policies.action.views.pixels import (
    GROUNDED_CHANNELS,
    PLAIN_CHANNELS,
    Painter,
    grounded_pixels,
    plain_pixels,
)


@dataclass(frozen=True)
class Design:
    """What is particular to a design.

    Attributes:
        build: the network of a stage, from (settings, width of the condition vector, width of the word vectors).
        paint: the channels of a rendered pixel.
        pool: features (B, V * C) for the pose, from (output, point (B, 3) in the cube, names of the views).
        pose_width: of the pose head's hidden layers.
        grounded: text and proprioception together modulate the network and reach the pose head, and each pixel's
            colour is matched with the words. Otherwise words are tokens and proprioception stands beside each patch.
    """

    build: Callable[[LlakeyActionConfig, int, int], ViewNetwork]
    paint: Painter
    pool: Callable[[ViewOutput, Tensor, Sequence[str]], Tensor]
    pose_width: int
    grounded: bool = False


def _small(config: LlakeyActionConfig, condition: int, text_width: int) -> ViewNetwork:
    return MultiViewNetwork(
        channels=GROUNDED_CHANNELS,
        matches=config.colour_queries,
        views=len(config.views),
        size=config.view_size,
        condition=condition,
        text_width=text_width,
        widths=config.widths,
        blocks=config.blocks,
        layers=config.transformer_layers,
        heads=config.transformer_heads,
    )


def _published(network: type[RvtNetwork] | type[Rvt2Network]) -> Callable[[LlakeyActionConfig, int, int], ViewNetwork]:
    def build(config: LlakeyActionConfig, condition: int, text_width: int) -> ViewNetwork:
        return network(
            channels=PLAIN_CHANNELS,
            views=len(config.views),
            size=config.view_size,
            patch=config.patch_size,
            condition=condition,
            text_width=text_width,
            width=config.token_width,
            layers=config.transformer_layers,
            heads=config.transformer_heads,
            dropout=config.attention_dropout,
        )

    return build


DESIGNS: dict[str, Design] = {
    "small": Design(_small, grounded_pixels, pooled_at, pose_width=256, grounded=True),
    "rvt": Design(_published(RvtNetwork), plain_pixels, heatmap_weighted, pose_width=192),
    "rvt2": Design(_published(Rvt2Network), plain_pixels, pooled_at, pose_width=256),
}


def make_text_encoder(config: LlakeyActionConfig) -> TextEncoder | HubTextEncoder:
    """The text encoder that the settings ask for.

    Raises:
        LlakeyError: if ``config.text_model`` names none.
    """
    if config.text_model is not None:
        return HubTextEncoder(config.text_model)
    return TextEncoder(config.text_width, config.text_layers, config.text_buckets, config.text_length)


def make_pose_head(config: LlakeyActionConfig, inputs: int) -> PoseHead:
    """The pose head that the settings ask for, on features of a width."""
    width, frames = DESIGNS[config.design].pose_width, config.rotation_frames
    if config.rotation == "sixd":
        return SixDHead(inputs, width, frames)
    head = BinsHead if config.rotation == "bins" else SequentialBinsHead
    return head(inputs, config.rotation_bins, width, frames)
