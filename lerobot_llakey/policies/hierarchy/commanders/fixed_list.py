"""A list of instructions that was written beforehand commands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said
from lerobot_llakey.policies.hierarchy.record import Step


class ListCommander(Commander):
    """Says the instructions of a list, one a step, in every row from its start; the last one over and over.

    A random move uses no instruction up: the row is given the same one again.

    Args:
        instructions: at least one text.

    Raises:
        LlakeyError: if the list is empty.
    """

    def __init__(self, instructions: Sequence[str]) -> None:
        if not instructions:
            raise LlakeyError("Expected at least one instruction for commander='list', got none; set instructions.")
        self.instructions = list(instructions)
        self._given: dict[int, int] = {}

    def reset(self) -> None:
        self._given.clear()

    def ask(self, batch: Mapping[str, Any], rows: Sequence[int], previous: Sequence[str]) -> list[Said]:
        last = len(self.instructions) - 1
        return [Said(self.instructions[min(self._given.get(row, 0), last)], "list") for row in rows]

    def sent(self, steps: Sequence[Step]) -> None:
        for step in steps:
            if step.source != "person" and not step.random_move:
                self._given[step.row] = self._given.get(step.row, 0) + 1
