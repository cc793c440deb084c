"""Which words steer the action policy: the basic action's instruction, the skill instruction, or both."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.texts import reworded, text_column


def read_texts(
    batch: Mapping[str, Any], config: LlakeyActionConfig, rows: int, rng: np.random.Generator | None = None
) -> list[list[str]]:
    """The texts that steer a batch, as ``config.condition_on`` asks: of the task, of the instruction, or of both.

    Without an instruction the expert's is read where the environment gives
    it.

    Args:
        batch: in the data contract.
        config: which texts steer.
        rows: how many the batch has.
        rng: in training, draws the rows whose last text is reworded; None rewords none.

    Returns:
        One list with a text for each row, or two: the tasks, then the instructions.

    Raises:
        LlakeyError: if texts are missing, not as many as the batch has rows, or wrong in a row.
    """
    parts: list[list[str]] = []
    if config.condition_on != "instruction":
        parts.append(text_column(batch, schema.TASK, rows))
    if config.condition_on != "task":
        parts.append(_instructions(batch, config, rows))
    if rng is not None:
        parts[-1] = [reworded(text, config.paraphrase_probability, rng, config.rules) for text in parts[-1]]
    return parts


def _instructions(batch: Mapping[str, Any], config: LlakeyActionConfig, rows: int) -> list[str]:
    if schema.INSTRUCTION in batch:
        return text_column(batch, schema.INSTRUCTION, rows)
    if schema.ORACLE_INSTRUCTION in batch:
        # Empty where the expert has nothing left to do.
        return text_column(batch, schema.ORACLE_INSTRUCTION, rows, may_be_empty=True)
    raise LlakeyError(
        f"Expected {schema.INSTRUCTION!r} in the batch, got {', '.join(sorted(batch))}; give an instruction a row, act "
        "in an environment with --env.oracle_instructions=true, compose a hierarchy, or train with condition_on=task."
    )
