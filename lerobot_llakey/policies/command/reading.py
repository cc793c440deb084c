"""What a batch tells the command policy in words: its prompts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.batch import read_hands
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.pose_text import PoseText
from lerobot_llakey.policies.command.prompt import Prompt
from lerobot_llakey.policies.texts import text_column


def read_prompts(
    batch: Mapping[str, Any], config: LlakeyCommandConfig, rng: np.random.Generator | None = None
) -> list[Prompt]:
    """The prompt of each row of a batch.

    Args:
        batch: with ``task`` as a list of str, ``previous_instruction`` where the history is on (a missing one counts as
            none) and ``observation.state`` where the hand is told.
        config: what is told.
        rng: in training, draws the rows whose previous instruction is hidden; None hides none.

    Raises:
        LlakeyError: if the task or the state is missing, or wrong in a row.
    """
    tasks = text_column(batch, schema.TASK)
    states: Sequence[str | None] = _states(batch, config) if config.uses_proprioception else [None] * len(tasks)
    previous: Sequence[str | None] = [None] * len(tasks)
    if config.history and config.target == "instruction":
        none = [""] * len(tasks)
        previous = text_column(batch, schema.PREVIOUS_INSTRUCTION, len(tasks), default=none, may_be_empty=True)
        if rng is not None:
            hidden = rng.random(len(tasks)) < config.history_dropout
            previous = ["" if hide else text for hide, text in zip(hidden, previous, strict=True)]
    return [Prompt(tuple(config.cameras), *told) for told in zip(tasks, previous, states, strict=True)]


def _states(batch: Mapping[str, Any], config: LlakeyCommandConfig) -> list[str]:
    """The robot's state of each row, as numbers."""
    if schema.STATE not in batch:
        raise LlakeyError(
            f"Expected {schema.STATE!r} in the batch for proprioception=pose, got {sorted(batch)}; use a dataset or an "
            "environment that has it."
        )
    text = PoseText(config.action_bins, config.box)
    return [text.encode_hand(hand) for hand in read_hands(batch, config.hand_columns).double().cpu().numpy()]
