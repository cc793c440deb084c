"""The language model's last layer, at the positions alone that are read."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor
from transformers.models.llama.modeling_llama import LlamaDecoderLayer, apply_rotary_pos_emb


class LastLayer(LlamaDecoderLayer):
    """A Llama layer that can leave out positions whose output nobody reads.

    Of a prompt of some 300 tokens only the last position is read to choose the answer's first token, and in training
    only those of the answer. The layer's keys and values are of all positions; its queries and all after them need not
    be. Its weights have the names and shapes of the class that it stands for.
    """

    def forward(self, hidden_states: Tensor, *args: Any, keep: int | None = None, **kwargs: Any) -> Tensor:
        """Hidden states (B, T, width) to those of the last ``keep`` positions, (B, keep, width); None keeps all.

        Args:
            hidden_states: of all positions.
            *args: as transformers hands them to a layer.
            keep: how many positions from the end are read.
            **kwargs: ``attention_mask``, ``past_key_values`` and ``position_embeddings``, as transformers gives them.
        """
        if keep is None or keep >= hidden_states.shape[1]:
            return super().forward(hidden_states, *args, **kwargs)
        attention = self.self_attn
        normed, read = self.input_layernorm(hidden_states), hidden_states[:, -keep:]
        query, key, value = (
            layer(part).unflatten(-1, (-1, attention.head_dim)).transpose(1, 2)
            for layer, part in (
                (attention.q_proj, normed[:, -keep:]),
                (attention.k_proj, normed),
                (attention.v_proj, normed),
            )
        )
        cos, sin = kwargs["position_embeddings"]
        _, key = apply_rotary_pos_emb(key, key, cos, sin)
        query, _ = apply_rotary_pos_emb(query, query, cos[:, -keep:], sin[:, -keep:])
        cache = kwargs.get("past_key_values")
        if cache is not None:
            key, value = cache.update(key, value, attention.layer_idx)
        scores = (query * attention.scaling) @ key.transpose(-1, -2)
        scores = scores + _mask(kwargs.get("attention_mask"), scores)
        attended = scores.softmax(dim=-1, dtype=torch.float32).to(value.dtype) @ value
        read = read + attention.o_proj(attended.transpose(1, 2).flatten(2))
        return read + self.mlp(self.post_attention_layernorm(read))


def read_last(model: Any, count: int) -> dict[str, int]:
    """What to tell an image-text model of whose output only the last positions are read; nothing to one that reads all.

    Args:
        model: any image-text model of transformers.
        count: of the positions.
    """
    layers = getattr(getattr(model.model, "language_model", None), "layers", [None])
    return {"keep": count} if isinstance(layers[-1], LastLayer) else {}


def _mask(given: Tensor | None, scores: Tensor) -> Tensor:
    """What is added to scores (B, heads, keep, T): 0 where a position may be looked at, else a very negative number."""
    keep, total = scores.shape[-2:]
    least = torch.finfo(scores.dtype).min
    if given is None:
        return scores.new_full((keep, total), least).triu(total - keep + 1)
    rows = given[..., -keep:, :total]
    return torch.zeros_like(rows, dtype=scores.dtype).masked_fill(~rows, least) if rows.dtype == torch.bool else rows
