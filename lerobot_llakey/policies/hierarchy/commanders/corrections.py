"""A person stands between a commander and the robot: corrections in words, and changed goals."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said
from lerobot_llakey.policies.hierarchy.motion import distance, turned
from lerobot_llakey.policies.hierarchy.record import Step

Hold = Literal["once", "done"]


@dataclass
class _Correction:
    text: str
    hold: Hold
    steps: int = 0
    goal: tuple[float, ...] | None = None


class Corrections(Commander):
    """Passes on what another commander says unless a person has said something else for the row.

    A correction is given from the next :meth:`ask` on. With hold "once" it is over after one step. With hold "done" it
    is given step after step until its keyframe is reached or ``max_steps`` steps were carried out with it. Its keyframe
    is the pose that was sent at the latest of these steps; it is reached when the next observation shows the hand
    within ``reach`` metres and ``reach_degrees`` of it. So a motion that failed is tried again, and one that arrived is
    not. A new correction takes the place of the one before. Corrections and goals of a row last no longer than the
    episode (:meth:`reset`). The stall rule leaves steps with a person's words alone.

    Every method may be called from any thread.

    Args:
        inner: who commands where the person is silent.
        grammar: of what a person may say.
        max_steps: after how many steps a correction held until done is given up.
        reach: metres from its keyframe within which a correction is done.
        reach_degrees: the same for the hand's orientation.
    """

    def __init__(
        self,
        inner: Commander,
        grammar: Grammar = BASIC_GRAMMAR,
        max_steps: int = 5,
        reach: float = 0.01,
        reach_degrees: float = 5.0,
    ) -> None:
        self.inner = inner
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
        """Change the goal of a row from the next :meth:`ask` on; "" brings the environment's own back."""
        with self._lock:
            if text.strip():
                self._tasks[row] = text.strip()
            else:
                self._tasks.pop(row, None)

    def task(self, row: int) -> str | None:
        """The goal that a person set for a row, None if it has the environment's own."""
        with self._lock:
            return self._tasks.get(row)

    def held(self, row: int) -> str | None:
        """The correction that stands for a row, None if there is none."""
        with self._lock:
            correction = self._corrections.get(row)
            return None if correction is None else correction.text

    def reset(self) -> None:
        with self._lock:
            self._corrections.clear()
            self._tasks.clear()
            self.inner.reset()

    def with_tasks(self, batch: Mapping[str, Any]) -> dict[str, Any]:
        """The batch with the goals that persons have set; the policies below read the goal from it."""
        changed = dict(batch)
        with self._lock:
            if self._tasks:
                rows = len(batch[schema.STATE])
                given = batch.get(schema.TASK, "")
                tasks = [given] * rows if isinstance(given, str) else [str(text) for text in given]
                changed[schema.TASK] = [self._tasks.get(row, text) for row, text in enumerate(tasks)]
        return changed

    def observe(self, hands: np.ndarray) -> None:
        with self._lock:
            for row, correction in list(self._corrections.items()):
                if correction.goal is None or row >= len(hands):
                    continue
                hand, goal = hands[row], np.array(correction.goal)
                if distance(hand, goal) <= self.reach and turned(hand, goal) <= self.reach_degrees:
                    del self._corrections[row]
        self.inner.observe(hands)

    def ask(self, batch: Mapping[str, Any], rows: Sequence[int], previous: Sequence[str]) -> list[Said]:
        with self._lock:
            said = {row: Said(self._corrections[row].text, "person") for row in rows if row in self._corrections}
            batch = self.with_tasks(batch)
        rest = [place for place, row in enumerate(rows) if row not in said]
        if rest:
            given = self.inner.ask(
                batch,
                [rows[place] for place in rest],
                [previous[place] for place in rest],
            )
            said |= {rows[place]: answer for place, answer in zip(rest, given, strict=True)}
        return [said[row] for row in rows]

    def sent(self, steps: Sequence[Step]) -> None:
        with self._lock:
            for step in steps:
                correction = self._corrections.get(step.row)
                if correction is None or step.source != "person" or step.said != correction.text:
                    continue
                correction.steps += 1
                correction.goal = step.sent
                if correction.hold == "once" or correction.steps >= self.max_steps:
                    del self._corrections[step.row]
            self.inner.sent(steps)
