"""While the arm moves, what it was last told holds, and no model need be asked.

A keyframe is where the arm comes to rest (paper, section III-A), which no single picture shows: just before it the
scene looks as at it. The joints' encoders tell the two apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.policies.batch import check_finite
from lerobot_llakey.policies.texts import text_column

MOVING_ABOVE = 0.1
"""Radians a second of the fastest joint: twice what keyframe discovery takes for rest, so that an arm that still
settles counts as standing."""


def moving(velocity: Tensor, above: float = MOVING_ABOVE) -> Tensor:
    """Whether the arm moves, (B,) bool, at velocities (B, 8) of the data contract."""
    return velocity[:, schema.ARM_VELOCITY].abs().amax(dim=1) > above


def held_instructions(batch: Mapping[str, Any], above: float | None) -> list[str | None]:
    """For each row of a batch the instruction that holds since its arm moves; None where the model is to be asked.

    Args:
        batch: with ``task`` as a list of B texts. Without ``observation.velocity`` (B, 8) or
            ``observation.previous_instruction`` the model is asked about all rows, as it is at the start of an episode.
        above: speed of the fastest joint in radians a second above which the arm moves; None asks about all rows.

    Raises:
        LlakeyError: if a task is missing or empty, or a velocity is not finite.
    """
    tasks = text_column(batch, schema.TASK)
    if above is None or schema.VELOCITY not in batch:
        return [None] * len(tasks)
    previous = text_column(batch, schema.PREVIOUS_INSTRUCTION, len(tasks), default=[""] * len(tasks), may_be_empty=True)
    check_finite(schema.VELOCITY, batch[schema.VELOCITY])
    moves = moving(batch[schema.VELOCITY], above).tolist()
    return [text or None if moved else None for text, moved in zip(previous, moves, strict=True)]
