"""One step of a drive: what the policy did, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.step_log import Step


@dataclass(frozen=True)
class DrivenStep:
    """A row of the table.

    Attributes:
        step: the policy's own record, made before the motion.
        failure: why the arm did not move, "" if it did.
        success: whether the simulator's task is done afterwards.
        own_goal: whether the goal was the scene's own, the only one that the simulator can judge.
    """

    step: Step
    failure: str
    success: bool
    own_goal: bool = True

    @property
    def result(self) -> str:
        """What came of it, in a word or two: moved, the reason why not, or success."""
        if self.success and self.own_goal:
            return "success"
        moved = self.failure or ("random move" if self.step.random_move else "moved")
        return f"{moved}; the scene's own task is done" if self.success else moved

    @property
    def pose(self) -> str:
        """Where the hand was sent: x, y, z in centimetres, the quaternion xyzw, and the gripper."""
        sent = np.array(self.step.sent)
        place = ", ".join(f"{100 * value:.1f}" for value in sent[schema.POSITION])
        turn = ", ".join(f"{value:.2f}" for value in sent[schema.QUATERNION])
        return f"({place}) cm, ({turn}), {'open' if sent[schema.GRIPPER] > 0.5 else 'closed'}"

    @property
    def likelihood(self) -> str:
        """Of the words, in per cent; a dash where it is unknown."""
        return "-" if self.step.likelihood is None else f"{100 * self.step.likelihood:.0f} %"

    def as_json(self) -> dict[str, Any]:
        """The step as plain values for ``json.dumps``."""
        outcome = {"failure": self.failure, "success": self.success, "own_goal": self.own_goal, "result": self.result}
        return self.step.as_json() | outcome
