"""Decoding any image-text model of transformers token by token, by its own ``generate``."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor
from transformers import LogitsProcessorList

from lerobot_llakey.policies.command.decoding.trie import KnownAnswers, Trie


def decode_by_steps(
    model: Any,
    inputs: dict[str, Tensor],
    trie: Trie | None,
    stop_id: int,
    pad_id: int,
    max_new_tokens: int,
) -> list[tuple[list[int], float]]:
    """Answers of a model; with the KV cache, and the images looked at once, as ``generate`` does it.

    Args:
        model: an image-text model whose generation ends with the stop token.
        inputs: as its processor gives them, padded on the left.
        trie: the known answers; None allows any token.
        stop_id: the token that ends an answer.
        pad_id: the token that fills up finished rows.
        max_new_tokens: longest answer.

    Returns:
        For each row its tokens and the logarithm of their likelihood, see :class:`Answer`.
    """
    length = inputs["input_ids"].shape[1]
    held = KnownAnswers(trie, length, pad_id) if trie is not None else None
    output = model.generate(
        **inputs,
        max_new_tokens=max_new_tokens,
        logits_processor=LogitsProcessorList([held] if held is not None else []),
        eos_token_id=stop_id,
        pad_token_id=pad_id,
        return_dict_in_generate=True,
        output_logits=True,
    )
    sequences = output.sequences[:, length:]
    total = torch.zeros(len(sequences), device=sequences.device)
    going = torch.ones(len(sequences), dtype=torch.bool, device=sequences.device)
    for step, logits in enumerate(output.logits):
        scores = logits.float()
        if held is not None:
            scores = held(output.sequences[:, : length + step], scores)
        told = torch.log_softmax(scores, dim=1).gather(1, sequences[:, step, None])[:, 0]
        total += torch.where(going, told, 0.0)
        going &= sequences[:, step] != stop_id
    return list(zip(sequences.tolist(), total.tolist(), strict=True))
