"""A row of the table says in words what came of a step."""

import json
from typing import Any

import pytest

from fakes_steps import a_step
from lerobot_llakey.drive.driven_step import DrivenStep


@pytest.mark.parametrize(
    ("outcome", "random_move", "result"),
    [
        (("", False, True), False, "moved"),
        (("unreachable", False, True), False, "unreachable"),
        (("", False, True), True, "random move"),
        (("", True, True), False, "success"),
        (("", True, False), False, "moved; the scene's own task is done"),
    ],
)
def test_the_result_in_words(outcome: Any, random_move: bool, result: str) -> None:
    assert DrivenStep(a_step(random_move=random_move), *outcome).result == result


def test_pose_likelihood_and_json() -> None:
    sent = (0.4, -0.1, 0.25, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    step = DrivenStep(a_step(sent=sent, likelihood=0.874), "", False)
    assert step.pose == "(40.0, -10.0, 25.0) cm, (1.00, 0.00, 0.00, 0.00), open" and step.likelihood == "87 %"
    assert DrivenStep(a_step(likelihood=None), "", False).likelihood == "-"
    line = json.loads(json.dumps(step.as_json()))
    assert line["result"] == "moved" and line["sent"] == list(sent) and line["own_goal"] is True
