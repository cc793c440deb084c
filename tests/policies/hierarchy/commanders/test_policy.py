import math
from typing import Any

import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.command.decoding.answer import Answer
from lerobot_llakey.policies.hierarchy.commanders.commander import Said
from lerobot_llakey.policies.hierarchy.commanders.policy import PolicyCommander


class Dice:
    """A command policy that says a number: its row's state."""

    def __init__(self) -> None:
        self.batches: list[dict[str, Any]] = []

    def reset(self) -> None:
        self.batches.clear()

    def answer(self, batch) -> list[Answer]:
        self.batches.append(batch)
        values = [row[0].item() for row in batch[schema.STATE]]
        return [Answer(f"{value:.6f}", math.nan if value == 0 else 0.25) for value in values]


def _batch(rows: int) -> dict[str, Any]:
    return {schema.STATE: torch.arange(rows)[:, None].repeat(1, 15).float(), schema.TASK: ["t"] * rows}


def test_asks_for_the_rows_with_what_was_said_before() -> None:
    commander = PolicyCommander(dice := Dice())
    said = commander.ask(_batch(3), [2, 1], ["before", ""])
    assert said == [Said("2.000000", "policy", 0.25), Said("1.000000", "policy", 0.25)]
    assert dice.batches[0][schema.PREVIOUS_INSTRUCTION] == ["before", ""]
    assert dice.batches[0][schema.TASK] == ["t", "t"]
    assert commander.ask(_batch(1), [0], [""])[0].likelihood is None
