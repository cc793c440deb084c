"""Number words that begin in their order: neighbours alike."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import nn

_SPREAD = 0.02
"""Standard deviation of a fresh embedding, as transformers begins them."""


@torch.no_grad()
def spread_numbers(embedding: nn.Embedding, tokens: Sequence[int]) -> None:
    """Set the embeddings of consecutive numbers to points along a smooth curve.

    Hundreds of numbers, each met in few samples, would have to be learned one by one; so what is learned of one holds
    for those beside it. The curve has waves from one over all numbers to one over four of them.

    Args:
        embedding: (vocabulary, width); changed in place.
        tokens: the numbers' token ids, in the order of the numbers.
    """
    count, width = len(tokens), embedding.embedding_dim
    waves = torch.logspace(0, math.log10(max(count / 4, 1)), width // 2)
    angles = torch.linspace(0, 2 * math.pi, count + 1)[:count, None] * waves
    curve = torch.stack((angles.sin(), angles.cos()), dim=-1).flatten(1) * _SPREAD * math.sqrt(2)
    embedding.weight[torch.tensor(tokens), : curve.shape[1]] = curve.to(embedding.weight)
