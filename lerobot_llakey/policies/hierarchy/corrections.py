"""A person stands between the commander and the robot: corrections in words, and changed goals."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees
from typing import Any, Literal

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import Pose
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.hierarchy.step_log import Step

Hold = Literal["once", "done"]


@dataclass
class _Correction:
    text: str
    hold: Hold
    steps: int = 0
    goal: tuple[float, ...] | None = None


class Corrections:
    """A person's words for single rows of a batch, which the loop takes in place of its commander's.

    A correction is given from the next decision on. With hold "once" it is over after one step. With hold "done" it is
    given step after step until its keyframe is reached or ``max_steps`` steps were carried out with it. Its keyframe is
    the pose that was sent at the latest of these steps; it is reached when the next observation shows the hand within
    ``reach`` metres and ``reach_degrees`` of it. So a motion that failed is tried again, and one that arrived is not. A
    new correction takes the place of the one before. Corrections and goals of a row last no longer than the episode
    (:meth:`reset`). The stall rule leaves steps with a person's words alone.

    Every method may be called from any thread.

    Args:
        grammar: of what a person may say.
        max_steps: after how many steps a correction held until done is given up.
        reach: metres from its keyframe within which a correction is done.
        reach_degrees: the same for the hand's orientation.
    """

    def __init__(
        self, grammar: Grammar = BASIC_GRAMMAR, max_steps: int = 5, reach: float = 0.01, reach_degrees: float = 5.0
    ) -> None:
        self.grammar = grammar
        self.max_steps = max_steps
        self.reach = reach
        self.reach_degrees = reach_degrees
        self._lock = threading.RLock()
        self._corrections: dict[int, _Correction] = {}
        self._tasks: dict[int, str] = {}

    def say(self, row: int, text: str, hold: Hold = "once") -> str:
        """Give a row this instruction in place of the commander's.

        Args:
            row: of the batch.
            text: a basic action, in any of its wordings.
            hold: "once" for one step, "done" until it is done (see above).

        Returns:
            The instruction in its canonical wording, as it will be carried out.

        Raises:
            LlakeyError: if the text is no basic action, or ``hold`` is neither.
        """
        if hold not in ("once", "done"):
            raise LlakeyError(f"Expected hold to be 'once' or 'done', got {hold!r}; pick one of these.")
        text = self.grammar.canonical(text)
        with self._lock:
            self._corrections[row] = _Correction(text, hold)
        return text

    def withdraw(self, row: int) -> None:
        """Take the correction of a row back; nothing happens if there is none."""
        with self._lock:
            self._corrections.pop(row, None)

    def change_task(self, row: int, text: str) -> None:
        """Change the goal of a row from the next decision on; "" brings the environment's own back."""
        with self._lock:
            if text.strip():
                self._tasks[row] = text.strip()
            else:
                self._tasks.pop(row, None)

    def task(self, row: int) -> str | None:
        """The goal that a person set for a row, None if it has the environment's own."""
        with self._lock:
            return self._tasks.get(row)

    def reset(self) -> None:
        """Forget all episodes."""
        with self._lock:
            self._corrections.clear()
            self._tasks.clear()

    def goals(self, batch: Mapping[str, Any], rows: int) -> tuple[list[str], Mapping[str, Any]]:
        """The skill instruction of each row, "" where there is none, and the batch with those that persons have set."""
        given = batch.get(schema.TASK, "")
        goals = [given] * rows if isinstance(given, str) else [str(text) for text in given]
        with self._lock:
            changed = [self._tasks.get(row, goal) for row, goal in enumerate(goals)]
        return changed, batch if changed == goals else {**batch, schema.TASK: changed}

    def standing(self, hands: np.ndarray) -> dict[int, str]:
        """The corrections that stand, by row, where the hands (B, 8) are now; nothing changes."""
        with self._lock:
            return {
                row: correction.text
                for row, correction in self._corrections.items()
                if row < len(hands) and not self._reached(correction, hands[row])
            }

    def sent(self, steps: Sequence[Step]) -> None:
        """Take note of what was carried out, one step for each row of the batch."""
        with self._lock:
            for step in steps:
                correction = self._corrections.get(step.row)
                if correction is None:
                    continue
                if self._reached(correction, step.state):
                    del self._corrections[step.row]
                elif step.source == "person" and step.said == correction.text:
                    correction.steps += 1
                    correction.goal = step.sent
                    if correction.hold == "once" or correction.steps >= self.max_steps:
                        del self._corrections[step.row]

    def _reached(self, correction: _Correction, hand: Sequence[float] | np.ndarray) -> bool:
        if correction.goal is None:
            return False
        distance, angle = Pose.of(hand).distance(Pose.of(correction.goal))
        return distance <= self.reach and degrees(angle) <= self.reach_degrees
