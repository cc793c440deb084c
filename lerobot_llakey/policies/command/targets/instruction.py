"""The paper's target: the next basic action in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.policies.command.decoding.trie import Trie
from lerobot_llakey.policies.command.encoding import Encoder
from lerobot_llakey.policies.command.targets.target import Target
from lerobot_llakey.policies.texts import text_column


class InstructionTarget(Target):
    """The next basic action in words.

    Args:
        known: the instructions known from training, or given by hand.
    """

    def __init__(self, known: Sequence[str]) -> None:
        self.known = list(known)

    def answers(self, batch: Mapping[str, Any]) -> list[str]:
        return text_column(batch, schema.INSTRUCTION)

    def trie(self, encoder: Encoder) -> Trie:
        return Trie(encoder.answer(text) for text in self.known)
