"""What a command policy learns to answer with."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

from lerobot_llakey.policies.command.decoding.trie import Trie
from lerobot_llakey.policies.command.encoding import Encoder


class Target(ABC):
    """What a command policy learns to answer with."""

    @abstractmethod
    def answers(self, batch: Mapping[str, Any]) -> list[str]:
        """The right answer of each row of a training batch.

        Raises:
            LlakeyError: if what it is made from is missing in the batch.
        """

    @abstractmethod
    def trie(self, encoder: Encoder) -> Trie:
        """All answers that there may be, as the tokens of an encoder; empty where they are not known."""
