"""An answer stays until the step is taken, even of a commander that never says the same twice."""

from typing import Any

import pytest
import torch

from fakes_steps import a_step
from lerobot_llakey import schema
from lerobot_llakey.drive.remembering import Remembering
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said


class _Fickle(Commander):
    def __init__(self) -> None:
        self.count, self.resets, self.steps = 0, 0, 0

    def reset(self) -> None:
        self.resets += 1

    def ask(self, batch: Any, rows: Any, previous: Any) -> list[Said]:
        self.count += 1
        return [Said(f"answer {self.count}", "policy")]

    def sent(self, steps: Any) -> None:
        self.steps += len(steps)


def _ask(commander: Commander, task: str = "tidy up", previous: str = "") -> str:
    batch = {schema.STATE: torch.zeros(1, schema.HAND_DIM), schema.TASK: [task]}
    return commander.ask(batch, [0], [previous])[0].text


def test_the_same_question_has_the_same_answer_until_the_step_is_taken() -> None:
    commander = Remembering(_Fickle())
    assert [_ask(commander), _ask(commander)] == ["answer 1", "answer 1"]
    commander.sent([a_step()])
    assert _ask(commander) == "answer 2" and commander.inner.steps == 1


def test_another_goal_or_instruction_is_another_question() -> None:
    commander = Remembering(_Fickle())
    answers = [
        _ask(commander),
        _ask(commander, task="go on"),
        _ask(commander, previous="grasp the lid"),
    ]
    assert len(set(answers)) == 3
    assert [said.text for said in commander.heard] == answers


def test_a_reset_forgets() -> None:
    commander = Remembering(_Fickle())
    _ask(commander)
    commander.reset()
    assert _ask(commander) == "answer 2" and commander.inner.resets == 1


def test_more_than_one_row_is_refused() -> None:
    with pytest.raises(ValueError, match="row 0 alone"):
        Remembering(_Fickle()).ask({}, [0, 1], ["", ""])
