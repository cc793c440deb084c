"""The loop's supervisor: what algorithm 1 of the paper remembers and corrects around the two networks, in numpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lerobot_llakey import instructions, schema
from lerobot_llakey.geometry import canonical_quaternion


@dataclass(frozen=True)
class SupervisorSettings:
    """What all rows of a batch share.

    Attributes:
        repeat_threshold: how often the same instruction may be repeated before random moves begin.
        random_move_probability: chance of a random move at each step after that.
        random_move_radius: metres around the gripper within which a random move ends.
        workspace: bounds in metres of x, y and z that a random move does not leave.
        fallback: instruction used while nothing valid was commanded yet.
        free_text: take any text as it is and count no repeats: for skill instructions, which stay the same throughout.
    """

    repeat_threshold: int = 3
    random_move_probability: float = 0.5
    random_move_radius: float = 0.1
    workspace: schema.Workspace = schema.WORKSPACE
    fallback: str = "raise the robotic arm"
    free_text: bool = False


class Supervisor:
    """Watches one episode: one row of a batch, from one reset to the next.

    A step is :meth:`accept` (the instruction), the action policy, then :meth:`adjust` (its action). The rules:
        - Instructions go on in their canonical wording. One that is not in the grammar is counted in ``unparsable`` and
          the last valid one kept, or the fallback if there is none.
        - ``repeats`` is how often the current instruction has been given again. It starts anew when the instruction
          changes and after a random move, which gives both policies a fresh view to try from.
        - Once ``repeats`` exceeds the threshold, each step is a random move with the given probability: the hand goes
          to a place drawn uniformly from a ball around its present position, with its present orientation and the
          gripper last commanded, planned without touching anything.
        - A condition in the words (grasp: closed, release: open) overrides the action's gripper, not a random move's.

    Args:
        settings: shared by all rows.
        rng: of the random moves; each row has its own.

    Attributes:
        previous: the instruction last commanded, "" before the first.
        repeats: see above.
        unparsable: number of texts that were not in the grammar.
        random_moves: number of random moves made.
    """

    def __init__(self, settings: SupervisorSettings, rng: np.random.Generator) -> None:
        self.settings = settings
        self.previous = ""
        self.repeats = 0
        self.unparsable = 0
        self.random_moves = 0
        self._rng = rng
        self._gripper: float | None = None

    def accept(self, text: str) -> str:
        """The instruction to carry out now, given what the commander said."""
        if self.settings.free_text:
            self.previous = text
            return text
        try:
            instruction = instructions.canonical(text)
        except ValueError:
            self.unparsable += 1
            instruction = self.previous or self.settings.fallback
        self.repeats = self.repeats + 1 if instruction == self.previous else 0
        self.previous = instruction
        return instruction

    def adjust(self, action: np.ndarray, state: np.ndarray) -> np.ndarray:
        """The action to execute for the accepted instruction.

        Args:
            action: (9,) as the action policy gave it, metres and xyzw in the base frame.
            state: (15,) the present state.

        Returns:
            (9,) float32 with a unit quaternion.

        Raises:
            ValueError: if the quaternion to execute is not four finite numbers of non-zero length.
        """
        adjusted = np.array(action, dtype=np.float64)
        implied = instructions.gripper_implied(self.previous)
        if implied is not None:
            adjusted[schema.GRIPPER] = float(implied)
        if self.repeats > self.settings.repeat_threshold and self._rng.random() < self.settings.random_move_probability:
            adjusted = self._random_move(np.asarray(state, dtype=np.float64))
        adjusted[schema.QUATERNION] = canonical_quaternion(adjusted[schema.QUATERNION])
        self._gripper = float(adjusted[schema.GRIPPER])
        return adjusted.astype(np.float32)

    def _random_move(self, state: np.ndarray) -> np.ndarray:
        self.repeats = 0
        self.random_moves += 1
        direction = self._rng.normal(size=3)
        distance = self.settings.random_move_radius * self._rng.random() ** (1 / 3)
        low, high = np.array(self.settings.workspace).T
        move = np.zeros(schema.ACTION_DIM)
        position = state[schema.POSITION] + distance * direction / np.linalg.norm(direction)
        move[schema.POSITION] = position.clip(low, high)
        move[schema.QUATERNION] = state[schema.QUATERNION]
        move[schema.GRIPPER] = float(state[schema.GRIPPER] > 0.5) if self._gripper is None else self._gripper
        return move
