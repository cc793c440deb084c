"""The loop's supervisor: what algorithm 1 of the paper remembers and corrects around the two networks, in numpy."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey import schema
from lerobot_llakey.geometry import Pose, canonical_quaternion
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.decision import Choice

_GRIPPER_STEP = 0.1
"""Change of the gripper's opening, 0..1, that counts as a motion."""
_STILL_METRES, _STILL_DEGREES = 0.005, 2.0
"""A step that moved the hand by less than both did not move it."""


class Supervisor:
    """Watches one episode: one row of a batch, from one reset to the next.

    When a step is committed, it is told the hand (:meth:`observe`), then the instruction (:meth:`accept`), then the
    action policy's action (:meth:`adjust`). The rules:
        - ``repeats`` is how often the current instruction has been given again. It starts anew when the instruction
          changes, after a random move, which gives both policies a fresh view to try from, and when a person speaks.
        - Once ``repeats`` exceeds the threshold, each step is a random move with the given probability: the hand goes
          to a place drawn uniformly from a ball around its present position, with its present orientation and the
          gripper last commanded, planned without touching anything.
        - A place outside the workspace is moved to its edge. A hand that is outside itself goes no further out.
        - A condition in the words (grasp: closed, release: open, and those of the settings) overrides the action, not
          a random move.

    Args:
        config: of the hierarchical policy, shared by all rows.
        rng: of the random moves; each row has its own.

    Attributes:
        last: the instruction last commanded, None before the first.
        repeats: see above.
        unparsable: number of texts that were not in the grammar.
        random_moves: number of random moves made.
        moved: whether the step before moved hand or gripper; None before the second observation.
    """

    def __init__(self, config: LlakeyConfig, rng: np.random.Generator) -> None:
        self.config = config
        self.last: Choice | None = None
        self.repeats = 0
        self.unparsable = 0
        self.random_moves = 0
        self.moved: bool | None = None
        self.rng = rng
        self._gripper: float | None = None
        self._state: np.ndarray | None = None

    def observe(self, state: np.ndarray) -> None:
        """Look at the hand (8,) before a step, and so at what the step before did."""
        before, now = self._state, np.array(state, dtype=np.float64)
        if before is not None:
            distance, angle = Pose.of(before).distance(Pose.of(now))
            self.moved = bool(
                distance >= _STILL_METRES
                or np.degrees(angle) >= _STILL_DEGREES
                or abs(before[schema.GRIPPER] - now[schema.GRIPPER]) >= _GRIPPER_STEP
            )
        self._state = now

    def accept(self, choice: Choice) -> None:
        """Take the instruction to carry out now; a person's words never count as a repetition."""
        self.unparsable += choice.unparsable
        counted = choice.source != "person" and self.config.commander != "task"  # a task stays the same throughout
        again = self.last is not None and self.last.instruction == choice.instruction
        self.repeats = self.repeats + 1 if counted and again else 0
        self.last = choice

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
        config, state = self.config, np.asarray(state, dtype=np.float64)
        if self.repeats > config.repeat_threshold and self.rng.random() < config.random_move_probability:
            adjusted = self._random_move(state)
        else:
            assert self.last is not None
            grammar, parsed = config.spoken, self.last.parsed
            adjusted = set_gripper(action, grammar.gripper_implied(parsed))
            adjusted[schema.QUATERNION] = canonical_quaternion(adjusted[schema.QUATERNION])
            if config.screw_about_tool_axis and parsed.template in grammar.about_tool_axis:
                adjusted = about_tool_axis(adjusted, state)
            if config.raise_upward and parsed.template in grammar.straight_up:
                adjusted = straight_up(adjusted, state)
        adjusted[schema.QUATERNION] = canonical_quaternion(adjusted[schema.QUATERNION])
        self._gripper = float(adjusted[schema.GRIPPER])
        return adjusted.astype(np.float32)

    def _random_move(self, state: np.ndarray) -> np.ndarray:
        self.repeats = 0
        self.random_moves += 1
        direction = self.rng.normal(size=3)
        reach = self.config.random_move_radius * self.rng.random() ** (1 / 3)
        hand = state[schema.POSITION]
        low, high = np.array(self.config.action.box).T
        # With the hand inside the bounds, no clipping can bring a place further away from it than it was.
        low, high = np.minimum(low, hand), np.maximum(high, hand)
        move = np.zeros(schema.ACTION_DIM)
        move[schema.POSITION] = (hand + reach * direction / np.linalg.norm(direction)).clip(low, high)
        move[schema.QUATERNION] = state[schema.QUATERNION]
        move[schema.GRIPPER] = float(state[schema.GRIPPER] > 0.5) if self._gripper is None else self._gripper
        return move


# Conditions hidden in the words of an instruction (algorithm 1 of the paper, lines 6 to 8).


def set_gripper(action: np.ndarray, implied: bool | None) -> np.ndarray:
    """The action (9,) with the gripper that the words ask for: True open, False closed, None as it is."""
    changed = np.array(action, dtype=np.float64)
    if implied is not None:
        changed[schema.GRIPPER] = float(implied)
    return changed


def about_tool_axis(action: np.ndarray, state: np.ndarray) -> np.ndarray:
    """The action (9,) with all motion taken out but that about and along the hand's own z axis: what a screw does.

    Args:
        action: with a quaternion of non-zero length.
        state: (15,) the present state.
    """
    changed = np.array(action, dtype=np.float64)
    present = Rotation.from_quat(state[schema.QUATERNION])
    _, _, z, w = (present.inv() * Rotation.from_quat(changed[schema.QUATERNION])).as_quat()
    # The twist of the swing-twist decomposition; half a turn about another axis has none.
    twist = Rotation.from_quat([0.0, 0.0, z, w]) if np.hypot(z, w) > 1e-6 else Rotation.identity()
    axis = present.as_matrix()[:, 2]
    position = np.asarray(state[schema.POSITION], dtype=np.float64)
    changed[schema.POSITION] = position + axis * (axis @ (changed[schema.POSITION] - position))
    changed[schema.QUATERNION] = (present * twist).as_quat()
    return changed


def straight_up(action: np.ndarray, state: np.ndarray) -> np.ndarray:
    """The action (9,) with the hand where it is or right above, at the height asked for if that is above."""
    changed = np.array(action, dtype=np.float64)
    x, y, z = np.asarray(state[schema.POSITION], dtype=np.float64)
    changed[schema.POSITION] = x, y, max(z, changed[2])
    return changed
