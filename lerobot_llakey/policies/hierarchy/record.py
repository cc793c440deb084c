"""What happened in one step of the loop, in a form that can be written down."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Step:
    """One step of one row.

    Attributes:
        row: of the batch.
        index: number of the step since the last reset, from 0.
        task: the skill instruction, "" if the batch had none.
        said: the words of the commander, as given.
        instruction: what was carried out: the words in their canonical form, or what took their place.
        source: who said it (see :class:`Said`), "fallback" where nothing valid was said yet, "previous" where the last
            valid instruction took the place of words outside the grammar.
        likelihood: of the words, in 0..1; None where that has no meaning or others took their place.
        unparsable: whether the words were outside the grammar in the end.
        repeats: how often the instruction was given again without a break, as the stall rule counted before the step.
        random_move: whether a random move took the proposed pose's place.
        moved: whether the step before moved the hand or the gripper; None at the first step.
        state: (8,) the hand before the step: position in metres, quaternion xyzw, gripper opening.
        proposed: (9,) action as the action policy gave it: metres, xyzw, gripper, collision flag.
        sent: (9,) action as it was sent.
    """

    row: int
    index: int
    task: str
    said: str
    instruction: str
    source: str
    likelihood: float | None
    unparsable: bool
    repeats: int
    random_move: bool
    moved: bool | None
    state: tuple[float, ...]
    proposed: tuple[float, ...]
    sent: tuple[float, ...]

    def as_json(self) -> dict[str, Any]:
        """The step as plain values for ``json.dumps``."""
        return {key: list(value) if isinstance(value, tuple) else value for key, value in asdict(self).items()}
