"""Who gives the next basic action: the command policy, the expert in the environment, the task itself, or a list."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import torch

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.decision import Said
from lerobot_llakey.policies.hierarchy.step_log import Step
from lerobot_llakey.policies.texts import text_column


class Commander(ABC):
    """Gives the next instruction of each row.

    The loop calls :meth:`reset` before an episode, and at each step :meth:`ask` and then :meth:`sent`. Asking changes
    nothing.
    """

    def reset(self) -> None:
        """Forget all episodes."""

    @abstractmethod
    def ask(self, batch: Mapping[str, Any], rows: Sequence[int], previous: Sequence[str]) -> list[Said]:
        """The next instruction of some rows.

        Args:
            batch: the observation of all B rows.
            rows: indices of the rows that are asked for.
            previous: the instruction last carried out in each of ``rows``, "" before the first.

        Returns:
            One answer for each of ``rows``.

        Raises:
            LlakeyError: if the batch lacks what the commander needs.
        """

    def sent(self, steps: Sequence[Step]) -> None:
        """Take note of what was carried out, one step for each row of the batch."""


class PolicyCommander(Commander):
    """The command policy commands: the loop of algorithm 1 of the paper.

    Args:
        command: the command policy, in evaluation mode.
    """

    def __init__(self, command: LlakeyCommandPolicy) -> None:
        self.command = command

    def reset(self) -> None:
        self.command.reset()

    def ask(self, batch: Mapping[str, Any], rows: Sequence[int], previous: Sequence[str]) -> list[Said]:
        part = take_rows(batch, rows) | {schema.PREVIOUS_INSTRUCTION: list(previous)}
        answers = self.command.answer(part)
        # A backend that does not tell likelihoods gives NaN.
        return [Said(one.text, "policy", None if math.isnan(one.likelihood) else one.likelihood) for one in answers]


class OracleCommander(Commander):
    """Passes on the expert's instruction that the environment sends along."""

    def ask(self, batch: Mapping[str, Any], rows: Sequence[int], previous: Sequence[str]) -> list[Said]:
        if schema.ORACLE_INSTRUCTION not in batch:
            raise LlakeyError(
                f"Expected {schema.ORACLE_INSTRUCTION!r} in the batch for commander='oracle', got {sorted(batch)}; "
                "switch it on in the environment (--env.oracle_instructions=true) or use commander=policy."
            )
        # Empty where the expert has nothing left to do.
        texts = text_column(batch, schema.ORACLE_INSTRUCTION, may_be_empty=True)
        return [Said(texts[row], "oracle") for row in rows]


class TaskCommander(Commander):
    """Says the skill instruction at every step."""

    def ask(self, batch: Mapping[str, Any], rows: Sequence[int], previous: Sequence[str]) -> list[Said]:
        texts = text_column(batch, schema.TASK)
        return [Said(texts[0] if isinstance(batch[schema.TASK], str) else texts[row], "task") for row in rows]


class ListCommander(Commander):
    """Says the instructions of a list, one a step, in every row from its start; the last one over and over.

    A random move uses no instruction up: the row is given the same one again.

    Args:
        instructions: at least one text.
    """

    def __init__(self, instructions: Sequence[str]) -> None:
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


def build_commander(config: LlakeyConfig, command: LlakeyCommandPolicy | None) -> Commander:
    """Who commands under these settings.

    Args:
        config: of the hierarchical policy.
        command: its command policy; None where another commands.

    Raises:
        LlakeyError: if the command policy answers with poses rather than instructions.
    """
    if command is not None:
        if command.config.target != "instruction":
            raise LlakeyError(
                f"Expected a command policy with target='instruction', got target={command.config.target!r}; it acts "
                "by itself: evaluate it alone, or train one that instructs."
            )
        return PolicyCommander(command)
    if config.commander == "list":
        return ListCommander(config.instructions)
    return OracleCommander() if config.commander == "oracle" else TaskCommander()


def take_rows(batch: Mapping[str, Any], rows: Sequence[int]) -> dict[str, Any]:
    """Some rows of a batch.

    Args:
        batch: tensors (B, ...) and lists of B; what has another length belongs to all rows and is kept.
        rows: indices below B.
    """
    count = len(batch[schema.STATE])
    chosen = torch.as_tensor(list(rows))

    def of(value: Any) -> Any:
        if isinstance(value, torch.Tensor) and value.ndim and len(value) == count:
            return value[chosen.to(value.device)]
        if isinstance(value, list | tuple) and len(value) == count:
            return [value[row] for row in rows]
        return value

    return {key: of(value) for key, value in batch.items()}
