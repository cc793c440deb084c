"""Greedy decoding, constrained to the known answers, by the fastest method that the model allows.

LLaVA's classes decode from branch to branch. The known answers share few branching points: after "grasp the" the model
chooses, after "the top" only "of the" can follow. Such a forced run passes through the language model together with the
choice before it, and what follows the last choice never does. A decision then takes one pass for the prompt and one for
each further choice (three or four for the nine tasks) instead of one for each token (about ten); the answers are the
same. All other models decode token by token with transformers' own ``generate``.
"""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor
from transformers import LlavaForConditionalGeneration, LogitsProcessorList

from lerobot_llakey.policies.command.decoding.answer import Answer
from lerobot_llakey.policies.command.decoding.trie import KnownAnswers, Node, Trie
from lerobot_llakey.policies.command.encoding import Encoder
from lerobot_llakey.policies.command.small.model import read_last


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
        encoder: the encoder that made the inputs.
        inputs: what :meth:`Encoder.prompts` returns.
        trie: the known answers; None or empty allows any.
        max_new_tokens: longest answer.
    """
    decode = decode_by_branches if isinstance(model, LlavaForConditionalGeneration) else decode_by_steps
    decoded = decode(model, inputs, trie or None, encoder.stop_id, encoder.pad_id, max_new_tokens)
    return [Answer(encoder.decode(ids), math.exp(logarithm)) for ids, logarithm in decoded]


def decode_by_steps(
    model: Any,
    inputs: dict[str, Tensor],
    trie: Trie | None,
    stop_id: int,
    pad_id: int,
    max_new_tokens: int,
) -> list[tuple[list[int], float]]:
    """Decode any image-text model token by token with its own ``generate``.

    Args:
        model: an image-text model whose generation ends with the stop token.
        inputs: what its processor returns, padded on the left.
        trie: the known answers; None allows any token.
        stop_id: the token that ends an answer.
        pad_id: the token that fills up finished rows.
        max_new_tokens: longest answer.

    Returns:
        The tokens of each row and the logarithm of their likelihood, see :class:`Answer`.
    """
    length = inputs["input_ids"].shape[1]
    constraint = KnownAnswers(trie, length, pad_id) if trie is not None else None
    output = model.generate(
        **inputs,
        max_new_tokens=max_new_tokens,
        logits_processor=LogitsProcessorList([constraint] if constraint is not None else []),
        eos_token_id=stop_id,
        pad_token_id=pad_id,
        return_dict_in_generate=True,
        output_logits=True,
    )
    sequences = output.sequences[:, length:]
    total = torch.zeros(len(sequences), device=sequences.device)
    unfinished = torch.ones(len(sequences), dtype=torch.bool, device=sequences.device)
    for step, logits in enumerate(output.logits):
        scores = logits.float()
        if constraint is not None:
            scores = constraint(output.sequences[:, : length + step], scores)
        log_likelihood = torch.log_softmax(scores, dim=1).gather(1, sequences[:, step, None])[:, 0]
        total += torch.where(unfinished, log_likelihood, 0.0)
        unfinished &= sequences[:, step] != stop_id
    return list(zip(sequences.tolist(), total.tolist(), strict=True))


class _Row:
    """One answer in the making.

    Attributes:
        ids: its tokens so far.
        processed: how many of them have passed through the model.
        log_likelihood: of the choices so far.
        done: whether it is complete.
    """

    def __init__(self, trie: Trie | None, stop_id: int, longest: int) -> None:
        self.ids: list[int] = []
        self.processed = 0
        self.log_likelihood = 0.0
        self._node: Node | None = trie.root if trie else None
        self._stop_id, self._longest = stop_id, longest
        self._take_forced()

    @property
    def done(self) -> bool:
        if len(self.ids) >= self._longest:
            return True
        return not self._node if self._node is not None else self.ids[-1:] == [self._stop_id]

    def pending(self) -> list[int]:
        """The tokens that must pass through the model before the next choice."""
        return [] if self.done else self.ids[self.processed :]

    def choose(self, scores: Tensor) -> None:
        """Choose the next token by its scores (vocabulary,), then continue to the next branching point."""
        self.processed = len(self.ids)
        allowed = sorted(self._node) if self._node is not None else None
        open_scores = scores if allowed is None else scores[allowed]
        index = int(open_scores.argmax())
        self.log_likelihood += float(torch.log_softmax(open_scores, dim=0)[index])
        self._take(index if allowed is None else allowed[index])
        self._take_forced()

    def _take(self, token: int) -> None:
        self.ids.append(token)
        if self._node is not None:
            self._node = self._node[token]

    def _take_forced(self) -> None:
        while self._node is not None and len(self._node) == 1 and len(self.ids) < self._longest:
            self._take(next(iter(self._node)))


def decode_by_branches(
    model: Any,
    inputs: dict[str, Tensor],
    trie: Trie | None,
    stop_id: int,
    pad_id: int,
    max_new_tokens: int,
) -> list[tuple[list[int], float]]:
    """Decode a ``LlavaForConditionalGeneration`` from branch to branch; images pass through its vision tower once.

    Args:
        model: the model, whose language model takes ``past_key_values`` and ``position_ids``.
        inputs: ``input_ids`` and ``attention_mask`` (B, T), padded on the left, and ``pixel_values``.
        trie: the known answers; None allows any token.
        stop_id: the token that ends an answer.
        pad_id: any token; it fills rows with fewer pending tokens than others.
        max_new_tokens: longest answer.

    Returns:
        The tokens of each row and the logarithm of their likelihood, see :class:`Answer`.
    """
    mask = inputs["attention_mask"]
    device = mask.device
    rows = [_Row(trie, stop_id, max_new_tokens) for _ in mask]
    lengths = mask.sum(dim=1)
    positions = (mask.cumsum(dim=1) - 1).clamp(min=0)
    last = read_last(model, 1)
    output = model.model(**inputs, position_ids=positions, use_cache=True, **last)
    while True:
        pending = [row.pending() for row in rows]
        width = max(map(len, pending))
        if width:
            # Padded on the left, so that the last column holds the last token of each row.
            ids = torch.tensor([[pad_id] * (width - len(part)) + part for part in pending], device=device)
            real = torch.tensor([[0] * (width - len(part)) + [1] * len(part) for part in pending], device=device)
            positions = lengths[:, None] + (real.cumsum(dim=1) - 1).clamp(min=0)
            mask, lengths = torch.cat((mask, real), dim=1), lengths + real.sum(dim=1)
            output = model.model.language_model(
                input_ids=ids,
                attention_mask=mask,
                position_ids=positions,
                past_key_values=output.past_key_values,
                use_cache=True,
                **last,
            )
        scores = model.lm_head(output.last_hidden_state[:, -1]).float()
        for row, row_scores in zip(rows, scores, strict=True):
            if not row.done:
                row.choose(row_scores)
        if all(row.done for row in rows):
            return [(row.ids, row.log_likelihood) for row in rows]
