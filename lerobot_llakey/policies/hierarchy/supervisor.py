"""The loop's supervisor: what algorithm 1 of the paper remembers and corrects around the two networks, in numpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import canonical_quaternion
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.hierarchy import implied
from lerobot_llakey.policies.hierarchy.motion import distance, turned

_GRIPPER_STEP = 0.1
"""Change of the gripper's opening, 0..1, that counts as a motion."""


@dataclass(frozen=True)
class SupervisorSettings:
    """What all rows of a batch share.

    Attributes:
        repeat_threshold: how often the same instruction may be repeated before random moves begin.
        random_move_probability: chance of a random move at each step after that.
        random_move_radius: metres around the gripper within which a random move ends.
        workspace: bounds in metres of x, y and z that a random move does not leave.
        fallback: instruction used while nothing valid was commanded yet; with None the arm keeps still: an error says
            so.
        grammar: which texts are instructions, and what they imply.
        count_repeats: whether repeats count; skill instructions stay the same throughout.
        screw_about_tool_axis: let a screwing hand turn about and move along its own z axis only.
        raise_upward: let a raised hand move straight up only.
        still_distance, still_degrees: a step that moved the hand by less than both, and the gripper by less than a
            tenth of its opening, did not move.
    """

    repeat_threshold: int = 3
    random_move_probability: float = 0.5
    random_move_radius: float = 0.1
    workspace: schema.Workspace = schema.WORKSPACE
    fallback: str | None = "raise the robotic arm"
    grammar: Grammar = BASIC_GRAMMAR
    count_repeats: bool = True
    screw_about_tool_axis: bool = False
    raise_upward: bool = False
    still_distance: float = 0.005
    still_degrees: float = 2.0


class Supervisor:
    """Watches one episode: one row of a batch, from one reset to the next.

    A step is :meth:`observe` (the state), :meth:`accept` (the instruction), the action policy, then :meth:`adjust` (its
    action). The rules:
        - Instructions go on in their canonical wording. One that is not in the grammar is counted in ``unparsable`` and
          the last valid one kept, or the fallback if there is none.
        - ``repeats`` is how often the current instruction has been given again. It starts anew when the instruction
          changes, after a random move, which gives both policies a fresh view to try from, and when a person speaks.
        - Once ``repeats`` exceeds the threshold, each step is a random move with the given probability: the hand goes
          to a place drawn uniformly from a ball around its present position, with its present orientation and the
          gripper last commanded, planned without touching anything.
        - A place outside the workspace is moved to its edge. A hand that is outside itself goes no further out.
        - A condition in the words (grasp: closed, release: open, and those of the settings) overrides the action, not
          a random move.

    Args:
        settings: shared by all rows.
        rng: of the random moves; each row has its own.

    Attributes:
        previous: the instruction last commanded, "" before the first.
        repeats: see above.
        unparsable: number of texts that were not in the grammar.
        random_moves: number of random moves made.
        moved: whether the step before moved hand or gripper; None before the second observation.
        took: whose words the accepted instruction is: "said", or "previous" or "fallback" in place of unparsable ones.
    """

    def __init__(self, settings: SupervisorSettings, rng: np.random.Generator) -> None:
        self.settings = settings
        self.previous = ""
        self.repeats = 0
        self.unparsable = 0
        self.random_moves = 0
        self.moved: bool | None = None
        self.took = "said"
        self.rng = rng
        self._gripper: float | None = None
        self._state: np.ndarray | None = None

    def observe(self, state: np.ndarray) -> None:
        """Look at the hand (8,) before a step, and so at what the step before did."""
        before, now = self._state, np.array(state, dtype=np.float64)
        if before is not None:
            self.moved = bool(
                distance(before, now) >= self.settings.still_distance
                or turned(before, now) >= self.settings.still_degrees
                or abs(before[schema.GRIPPER] - now[schema.GRIPPER]) >= _GRIPPER_STEP
            )
        self._state = now

    def reading(self, text: str) -> str | None:
        """A text as it would be carried out, None if it is outside the grammar."""
        grammar = self.settings.grammar
        return grammar.canonical(text) if grammar.is_parsable(text) else None

    def accept(self, text: str, counted: bool = True) -> str:
        """The instruction to carry out now, given what the commander said.

        Args:
            text: its words.
            counted: whether they count as a repetition if they are one; a person's do not.

        Raises:
            LlakeyError: if nothing was ever said that can be read, and there is no fallback.
        """
        instruction, self.took = self.reading(text), "said"
        if instruction is None:
            self.unparsable += 1
            self.took = "previous" if self.previous else "fallback"
            instruction = self.previous or self.settings.fallback
        if instruction is None:
            raise LlakeyError(
                f"Expected an instruction of {self.settings.grammar.name}, got {text[:80]!r} and none before it, so "
                "the arm keeps still; set --policy.fallback_instruction to what is done then."
            )
        counted = counted and self.settings.count_repeats
        self.repeats = self.repeats + 1 if counted and instruction == self.previous else 0
        self.previous = instruction
        return instruction

    def adjust(self, action: np.ndarray, state: np.ndarray) -> np.ndarray:
        """The action to execute for the accepted instruction.

        Args:
            action: (9,) as the action policy gave it, metres and xyzw in the base frame.
            state: (8,) the present hand.

        Returns:
            (9,) float32 with a unit quaternion.

        Raises:
            LlakeyError: if the quaternion to execute is not four finite numbers of non-zero length.
        """
        settings, state = self.settings, np.asarray(state, dtype=np.float64)
        if self.repeats > settings.repeat_threshold and self.rng.random() < settings.random_move_probability:
            adjusted = self._random_move(state)
        else:
            grammar, instruction = settings.grammar, settings.grammar.parsed_or_none(self.previous)
            adjusted = implied.set_gripper(action, grammar.gripper_implied(self.previous))
            adjusted[schema.QUATERNION] = canonical_quaternion(adjusted[schema.QUATERNION])
            template = None if instruction is None else instruction.template
            if settings.screw_about_tool_axis and template in grammar.about_tool_axis:
                adjusted = implied.about_tool_axis(adjusted, state)
            if settings.raise_upward and template in grammar.straight_up:
                adjusted = implied.straight_up(adjusted, state)
        adjusted[schema.QUATERNION] = canonical_quaternion(adjusted[schema.QUATERNION])
        self._gripper = float(adjusted[schema.GRIPPER])
        return adjusted.astype(np.float32)

    def _random_move(self, state: np.ndarray) -> np.ndarray:
        self.repeats = 0
        self.random_moves += 1
        direction = self.rng.normal(size=3)
        reach = self.settings.random_move_radius * self.rng.random() ** (1 / 3)
        hand = state[schema.POSITION]
        low, high = np.array(self.settings.workspace).T
        # With the hand inside the bounds, no clipping can bring a place further away from it than it was.
        low, high = np.minimum(low, hand), np.maximum(high, hand)
        move = np.zeros(schema.ACTION_DIM)
        move[schema.POSITION] = (hand + reach * direction / np.linalg.norm(direction)).clip(low, high)
        move[schema.QUATERNION] = state[schema.QUATERNION]
        move[schema.GRIPPER] = float(state[schema.GRIPPER] > 0.5) if self._gripper is None else self._gripper
        return move
