"""Decoding LLaVA's classes from branch to branch: tokens that can only be one are not asked for.

The known answers share few branching points: after "grasp the" the model chooses, after "the top" only "of the" can
follow. A run of such tokens goes through the language model at once, together with the choice before it, and what
follows the last choice not at all. So a decision takes a pass for the prompt and one for each further choice (three or
four for the nine tasks) rather than one for each token (about ten), with the same answers as step by step.
"""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor

from lerobot_llakey.policies.command.decoding.trie import Node, Trie
from lerobot_llakey.policies.command.small.last_layer import read_last


class _Row:
    """One answer in the making.

    Attributes:
        ids: its tokens so far.
        seen: how many of them went through the model.
        log_likelihood: of the choices so far.
        done: whether it is complete.
    """

    def __init__(self, trie: Trie | None, stop_id: int, longest: int) -> None:
        self.ids: list[int] = []
        self.seen = 0
        self.log_likelihood = 0.0
        self._node: Node | None = trie.root if trie else None
        self._stop_id, self._longest = stop_id, longest
        self._go_on()

    @property
    def done(self) -> bool:
        if len(self.ids) >= self._longest:
            return True
        return not self._node if self._node is not None else self.ids[-1:] == [self._stop_id]

    def fresh(self) -> list[int]:
        """The tokens that the model has still to see before the next choice."""
        return [] if self.done else self.ids[self.seen :]

    def choose(self, scores: Tensor) -> None:
        """Go on by one choice, given the scores (vocabulary,) of the next token, to the next branch."""
        self.seen = len(self.ids)
        allowed = sorted(self._node) if self._node is not None else None
        open_scores = scores if allowed is None else scores[allowed]
        index = int(open_scores.argmax())
        self.log_likelihood += float(torch.log_softmax(open_scores, dim=0)[index])
        self._take(index if allowed is None else allowed[index])
        self._go_on()

    def _take(self, token: int) -> None:
        self.ids.append(token)
        if self._node is not None:
            self._node = self._node[token]

    def _go_on(self) -> None:
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
    """Answers of a ``LlavaForConditionalGeneration``; the images are looked at once.

    Args:
        model: the model, whose language model takes ``past_key_values`` and ``position_ids``.
        inputs: ``input_ids`` and ``attention_mask`` (B, T), padded on the left, and ``pixel_values``.
        trie: the known answers; None allows any token.
        stop_id: the token that ends an answer.
        pad_id: any token, for rows that have less to say than others.
        max_new_tokens: longest answer.

    Returns:
        For each row its tokens and the logarithm of their likelihood, see :class:`Answer`.
    """
    mask = inputs["attention_mask"]
    device = mask.device
    rows = [_Row(trie, stop_id, max_new_tokens) for _ in mask]
    lengths = mask.sum(dim=1)
    positions = (mask.cumsum(dim=1) - 1).clamp(min=0)
    last = read_last(model, 1)
    output = model.model(**inputs, position_ids=positions, use_cache=True, **last)
    while True:
        fresh = [row.fresh() for row in rows]
        width = max(map(len, fresh))
        if width:
            # Padded on the left, so that the last column holds the last token of each row.
            ids = torch.tensor([[pad_id] * (width - len(part)) + part for part in fresh], device=device)
            real = torch.tensor([[0] * (width - len(part)) + [1] * len(part) for part in fresh], device=device)
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
        for row, of_row in zip(rows, scores, strict=True):
            if not row.done:
                row.choose(of_row)
        if all(row.done for row in rows):
            return [(row.ids, row.log_likelihood) for row in rows]
