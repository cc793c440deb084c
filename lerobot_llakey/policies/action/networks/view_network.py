"""What every design's network has in common: rendered views in, scored pixels and features out."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor, nn


@dataclass
class ViewOutput:
    """What a stage sees.

    Attributes:
        heatmap: (B, V, S, S) float32 logits over the pixels of each view.
        features: (B, V, h, w, C) features of the views' places, at the design's own resolution.
        summary: (B, D) features of the whole scene.
    """

    heatmap: Tensor
    features: Tensor
    summary: Tensor


class ViewNetwork(nn.Module):
    """Base of the designs' networks.

    Attributes:
        feature_width: C of :attr:`ViewOutput.features`.
        summary_width: D of :attr:`ViewOutput.summary`.
    """

    feature_width: int
    summary_width: int

    def forward(
        self, images: Tensor, matches: Tensor | None, condition: Tensor, words: Tensor, padding: Tensor
    ) -> ViewOutput:
        """Look at rendered views.

        Args:
            images: (B, V, S, S, C) the design's pixels, see :mod:`views.pixels`.
            matches: (B, V, S, S, Q) how well each pixel's colour fits the words, where the design asks for it.
            condition: (B, D) condition vector beside the words.
            words: (B, T, W) word vectors.
            padding: (B, T) bool, true where there is no word.
        """
        raise NotImplementedError
