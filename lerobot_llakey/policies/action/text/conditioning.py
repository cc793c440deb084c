"""Which words steer the action policy: the basic action's instruction, the skill instruction, or both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lerobot_llakey import instructions, schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig


def read_texts(batch: Mapping[str, Any], config: LlakeyActionConfig) -> list[list[str]]:
    """The texts that steer a batch, as ``config.condition_on`` asks: of the task, of the instruction, or of both.

    Without an instruction column the expert's instruction is read where ``config.instruction_source`` allows it and
    the environment gives it, and the skill instruction otherwise.

    Returns:
        One list with a text for each row, or two: the tasks, then the instructions.

    Raises:
        ValueError: if a column of texts is missing, of another length than the batch, or empty in a row.
    """
    rows = len(batch[schema.INTRINSICS])
    parts: list[list[str]] = []
    if config.condition_on != "instruction":
        parts.append(_column(batch, schema.TASK, rows))
    if config.condition_on != "task":
        parts.append(_instructions(batch, config, rows))
    return parts


def reworded(text: str, probability: float, rng: np.random.Generator) -> str:
    """The instruction, replaced by a synonym with the given probability."""
    if rng.random() >= probability:
        return text
    # A text outside the grammar, such as a person's own wording, has no synonym.
    return instructions.paraphrase(text, rng) if instructions.is_parsable(text) else text


def _instructions(batch: Mapping[str, Any], config: LlakeyActionConfig, rows: int) -> list[str]:
    if schema.INSTRUCTION in batch:
        return _column(batch, schema.INSTRUCTION, rows)
    if config.instruction_source == "oracle" and schema.ORACLE_INSTRUCTION in batch:
        return [schema.decode_text(codes.cpu()) for codes in batch[schema.ORACLE_INSTRUCTION]]
    return _column(batch, schema.TASK, rows)


def _column(batch: Mapping[str, Any], key: str, rows: int) -> list[str]:
    texts = batch.get(key)
    texts = [texts] if isinstance(texts, str) else texts
    if not isinstance(texts, Sequence) or len(texts) != rows:
        raise LlakeyError(
            f"Expected {key} as {rows} texts, one for each batch row, got "
            f"{'none' if texts is None else f'{len(texts)}'}; give the policy its instruction."
        )
    empty = [row for row, text in enumerate(texts) if not str(text).strip()]
    if empty:
        raise LlakeyError(
            f"Expected words in {key}, got an empty text in batch row {empty[0]}; give the policy its instruction."
        )
    return [str(text) for text in texts]
