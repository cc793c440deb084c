"""The command policy commands: the loop of algorithm 1 of the paper."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.policies.command.decoding.answer import Answer
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said, take_rows


class PolicyCommander(Commander):
    """Asks a command policy.

    Args:
        command: the command policy, in evaluation mode.
    """

    def __init__(self, command: LlakeyCommandPolicy) -> None:
        self.command = command

    def reset(self) -> None:
        self.command.reset()

    def ask(self, batch: Mapping[str, Any], rows: Sequence[int], previous: Sequence[str]) -> list[Said]:
        part = take_rows(batch, rows) | {schema.PREVIOUS_INSTRUCTION: list(previous)}
        return [_said(answer) for answer in self.command.answer(part)]


def _said(answer: Answer) -> Said:
    """A backend that does not tell likelihoods gives NaN."""
    return Said(answer.text, "policy", None if math.isnan(answer.likelihood) else answer.likelihood)
