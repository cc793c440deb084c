"""From a model's inputs to answers, in the fastest way that the model allows."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from typing import Any

import torch
from torch import Tensor
from transformers import LlavaForConditionalGeneration

from lerobot_llakey.policies.command.decoding.answer import Answer
from lerobot_llakey.policies.command.decoding.branches import decode_by_branches
from lerobot_llakey.policies.command.decoding.choice import GREEDY, Choice
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
    choice: Choice = GREEDY,
    seed: int | None = None,
) -> list[Answer]:
    """One answer for each row of inputs.

    Args:
        model: an image-text model of transformers.
        encoder: made the inputs.
        inputs: what :meth:`Encoder.prompts` returns.
        trie: the known answers; None allows any.
        max_new_tokens: longest answer.
        choice: greedy, or drawn.
        seed: of the draws, which leaves PyTorch's generator as it was; None goes on with that generator.
    """
    decode = decode_by_branches if isinstance(model, LlavaForConditionalGeneration) else decode_by_steps
    with _seeded(seed):
        decoded = decode(model, inputs, trie or None, choice, encoder.stop_id, encoder.pad_id, max_new_tokens)
    return [Answer(encoder.decode(ids), math.exp(logarithm)) for ids, logarithm in decoded]


@contextlib.contextmanager
def _seeded(seed: int | None) -> Iterator[None]:
    if seed is None:
        yield
        return
    with torch.random.fork_rng():
        torch.manual_seed(seed)
        yield
