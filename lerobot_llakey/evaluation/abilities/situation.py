"""What the robot was doing in a frame, and whether what it was last told to do was done.

A robot that moves has not finished; whether one that stands has, only the scene tells. At the start of an episode it
was told nothing yet.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.policies.command.motion_gate import moving

START, MOVING = "at the start", "moving its arm"
UNFINISHED, FINISHED = "standing, the same again", "standing, another one next"
SITUATIONS = (START, MOVING, UNFINISHED, FINISHED)


def situations(batch: dict[str, Any], joints: Sequence[int]) -> list[str]:
    """For each frame of a batch one of :data:`SITUATIONS`.

    Args:
        batch: as a dataset gives it, in the data contract; without velocities or previous instructions nothing is known
            ("" each).
        joints: places of the joints among the velocities; without any nothing is known either.
    """
    expected = list(batch[schema.INSTRUCTION])
    if not joints or schema.VELOCITY not in batch or schema.PREVIOUS_INSTRUCTION not in batch:
        return [""] * len(expected)
    rows = zip(
        moving(batch[schema.VELOCITY][:, list(joints)]).tolist(),
        batch[schema.PREVIOUS_INSTRUCTION],
        expected,
        strict=True,
    )
    return [_situation(*row) for row in rows]


def _situation(moves: bool, previous: str, expected: str) -> str:
    if not previous:
        return START
    if moves:
        return MOVING
    return UNFINISHED if expected == previous else FINISHED
