"""From a model's inputs to answers, in the fastest way that the model allows."""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor
from transformers import LlavaForConditionalGeneration

from lerobot_llakey.policies.command.decoding.answer import Answer
from lerobot_llakey.policies.command.decoding.branches import decode_by_branches
from lerobot_llakey.policies.command.decoding.steps import decode_by_steps
from lerobot_llakey.policies.command.decoding.trie import Trie
from lerobot_llakey.policies.command.encoding import Encoder


@torch.no_grad()
def decode_answers(
    model: Any,
    encoder: Encoder,
    inputs: dict[str, Tensor],
    trie: Trie | None,
    max_new_tokens: int,
) -> list[Answer]:
    """One answer for each row of inputs.

    Args:
        model: an image-text model of transformers.
        encoder: made the inputs.
        inputs: what :meth:`Encoder.prompts` returns.
        trie: the known answers; None allows any.
        max_new_tokens: longest answer.
    """
    decode = decode_by_branches if isinstance(model, LlavaForConditionalGeneration) else decode_by_steps
    decoded = decode(model, inputs, trie or None, encoder.stop_id, encoder.pad_id, max_new_tokens)
    return [Answer(encoder.decode(ids), math.exp(logarithm)) for ids, logarithm in decoded]
