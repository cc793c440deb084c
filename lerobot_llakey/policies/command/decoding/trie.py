"""The known answers as a trie of tokens, and the constraint of generation to them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import torch
from torch import Tensor
from transformers import LogitsProcessor

Node = dict[int, "Node"]


class Trie:
    """The token sequences of all possible answers.

    Args:
        sequences: token ids, each ending with the stop token.
    """

    def __init__(self, sequences: Iterable[Sequence[int]]) -> None:
        self.root: Node = {}
        for sequence in sequences:
            node = self.root
            for token in sequence:
                node = node.setdefault(token, {})

    def __bool__(self) -> bool:
        """Whether any answer is known."""
        return bool(self.root)

    def next_tokens(self, prefix: Sequence[int]) -> list[int]:
        """The tokens that may follow a prefix; empty after a complete sequence or outside the trie."""
        node = self.root
        for token in prefix:
            node = node.get(token, {})
        return list(node)


class KnownAnswers(LogitsProcessor):
    """Allows only tokens that continue a known answer.

    Args:
        trie: the known answers.
        prompt_length: number of tokens before the answer.
        pad_id: the token that follows a complete answer.
    """

    def __init__(self, trie: Trie, prompt_length: int, pad_id: int) -> None:
        self.trie = trie
        self.prompt_length = prompt_length
        self.pad_id = pad_id

    def __call__(self, input_ids: Tensor, scores: Tensor) -> Tensor:
        """Scores (B, vocabulary) after ids (B, T), minus infinity for tokens that continue no known answer."""
        constrained = torch.full_like(scores, -torch.inf)
        for row, ids in enumerate(input_ids[:, self.prompt_length :].tolist()):
            allowed = self.trie.next_tokens(ids) or [self.pad_id]
            constrained[row, allowed] = scores[row, allowed]
        return constrained
