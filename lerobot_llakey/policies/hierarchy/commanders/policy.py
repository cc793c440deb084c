"""The command policy commands: the loop of algorithm 1 of the paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said, take_rows


class PolicyCommander(Commander):
    """Asks a command policy.

    Args:
        command: the command policy, in evaluation mode.
        temperature: of sampled answers; 1 is the model's own distribution.
    """

    def __init__(self, command: LlakeyCommandPolicy, temperature: float = 1.0) -> None:
        self.command = command
        self.temperature = temperature

    def reset(self) -> None:
        self.command.reset()

    def ask(
        self,
        batch: Mapping[str, Any],
        rows: Sequence[int],
        previous: Sequence[str],
        sample: bool = False,
        seeds: Sequence[int] = (),
    ) -> list[Said]:
        part = take_rows(batch, rows) | {schema.PREVIOUS_INSTRUCTION: list(previous)}
        if not hasattr(self.command, "answer"):
            return [Said(text, "policy") for text in self.command.next_instructions(part)]
        if not sample:
            return [Said(answer.text, "policy", answer.likelihood) for answer in self.command.answer(part)]
        # One row at a time, each from its own seed: what is drawn must not depend on the other rows.
        said = []
        for place in range(len(rows)):
            row = take_rows(part, [place])
            with torch.random.fork_rng():
                torch.manual_seed(seeds[place] if seeds else rows[place])
                answer = self.command.answer(row, sample=True, temperature=self.temperature)[0]
            said.append(Said(answer.text, "policy", answer.likelihood))
        return said
