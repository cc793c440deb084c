"""A commander whose answers stay the same until a step is carried out, whatever stands behind it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said
from lerobot_llakey.policies.hierarchy.record import Step

_Question = tuple[str, str]


class Remembering(Commander):
    """Asks another commander each question once a step, for one row.

    A page shows what is proposed, and the policy asks again when it acts: with this in between, a chat model that never
    says the same twice is held to what it proposed, and is not paid twice.

    Args:
        inner: who is asked.

    Attributes:
        heard: the answers given since the list was last emptied, repeated ones included.
    """

    def __init__(self, inner: Commander) -> None:
        self.inner = inner
        self.heard: list[Said] = []
        self._answers: dict[_Question, Said] = {}

    def reset(self) -> None:
        self._answers.clear()
        self.inner.reset()

    def ask(self, batch: Mapping[str, Any], rows: Sequence[int], previous: Sequence[str]) -> list[Said]:
        if list(rows) != [0]:
            raise LlakeyError(
                f"Expected a question about row 0 alone, got rows {list(rows)}; drive one scene at a time."
            )
        task = batch.get(schema.TASK, "")
        question = (task if isinstance(task, str) else str(task[0]), previous[0])
        if question not in self._answers:
            self._answers[question] = self.inner.ask(batch, rows, previous)[0]
        self.heard.append(self._answers[question])
        return [self._answers[question]]

    def observe(self, hands: np.ndarray) -> None:
        self.inner.observe(hands)

    def with_tasks(self, batch: Mapping[str, Any]) -> Mapping[str, Any]:
        return self.inner.with_tasks(batch)

    def sent(self, steps: Sequence[Step]) -> None:
        self._answers.clear()
        self.inner.sent(steps)
