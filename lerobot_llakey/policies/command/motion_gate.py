"""The motion gate: while the arm moves, the last instruction stays and no model is asked.

The arm comes to rest at a keyframe (paper, section III-A). A single image does not show that: the scene looks the same
just before. The joints' velocities do.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.batch import check_finite, read_numbers
from lerobot_llakey.policies.texts import text_column

MOVING_ABOVE = 0.1
"""Radians a second of the fastest joint: twice the limit of keyframe discovery, so that an arm that is still settling
counts as standing."""


def moving(velocities: Tensor, above: float = MOVING_ABOVE) -> Tensor:
    """Whether the arm moves, (B,) bool, at velocities (B, J) of its joints; without joints it counts as standing."""
    return (velocities.abs() > above).any(dim=1)


def gated_instructions(batch: Mapping[str, Any], above: float | None, joints: int) -> list[str | None]:
    """The previous instruction of each row with a moving arm; None where the model must be asked.

    Args:
        batch: with ``task`` as a list of B texts. Without ``observation.velocity`` (B, joints and the gripper) or
            ``previous_instruction`` the model is asked about all rows, as it is at the start of an episode.
        above: speed of the fastest joint in radians a second above which the arm moves; None asks about all rows.
        joints: number of joints, whose velocities come first.

    Raises:
        LlakeyError: if a task is missing or empty, or a velocity is missing or not finite.
    """
    tasks = text_column(batch, schema.TASK)
    if above is None or not joints or schema.VELOCITY not in batch:
        return [None] * len(tasks)
    previous = text_column(batch, schema.PREVIOUS_INSTRUCTION, len(tasks), default=[""] * len(tasks), may_be_empty=True)
    velocities = read_numbers(batch, schema.VELOCITY, ("joints and gripper",), len(tasks))
    if velocities.shape[1] not in (joints, joints + 1):
        raise LlakeyError(
            f"Expected {schema.VELOCITY} of {joints} joints, and of the gripper where there is one, got "
            f"{velocities.shape[1]} numbers; give those of the robot that the policy was trained on."
        )
    check_finite(schema.VELOCITY, velocities)
    moves = moving(velocities[:, :joints], above).tolist()
    return [text or None if moved else None for text, moved in zip(previous, moves, strict=True)]
