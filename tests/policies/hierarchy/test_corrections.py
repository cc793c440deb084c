import threading
from collections.abc import Sequence
from typing import Any

import pytest
import torch

from fakes_steps import a_step
from lerobot_llakey import schema
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.policies.hierarchy.corrections import Corrections


def _batch(x: Sequence[float] = (0.0, 0.0, 0.0)) -> dict[str, Any]:
    state = torch.zeros(len(x), schema.HAND_DIM)
    state[:, 0] = torch.tensor(x)
    state[:, 6] = 1.0
    return {schema.STATE: state, schema.TASK: ["open", "close", "lift"][: len(x)]}


def _texts(corrections: Corrections, batch: dict[str, Any]) -> list[str]:
    """What is given in each row: a person's words, else the row and its goal."""
    goals, _ = corrections.goals(batch, len(batch[schema.STATE]))
    standing = corrections.standing(batch[schema.STATE].numpy())
    return [standing.get(row, f"{row}: {goal}") for row, goal in enumerate(goals)]


def _carried_out(corrections: Corrections, batch: dict[str, Any], goal: float = 0.5) -> list[str]:
    """One step of the loop, sent to x = ``goal``; what was done in each row."""
    texts, pose = _texts(corrections, batch), (goal, *(0.0,) * 5, 1.0, 0.0, 0.0)
    steps = []
    for row, (text, state) in enumerate(zip(texts, batch[schema.STATE].tolist(), strict=True)):
        source = "policy" if text.startswith(f"{row}: ") else "person"
        steps.append(a_step(row, said=text, source=source, sent=pose, state=tuple(state)))
    corrections.sent(steps)
    return texts


def test_is_silent_until_someone_speaks_and_then_for_that_row_alone() -> None:
    corrections = Corrections()
    assert _texts(corrections, _batch()) == ["0: open", "1: close", "2: lift"]
    assert corrections.say(1, "Grab the lid.") == "grasp the lid"
    assert corrections.standing(_batch()[schema.STATE].numpy()) == {1: "grasp the lid"}
    assert corrections.standing(_batch((0.0,))[schema.STATE].numpy()) == {}


def test_once_lasts_one_step_however_often_it_is_shown() -> None:
    corrections = Corrections()
    corrections.say(0, "grasp the lid")
    assert _texts(corrections, _batch())[0] == _texts(corrections, _batch())[0] == "grasp the lid"
    assert _carried_out(corrections, _batch())[0] == "grasp the lid"
    assert _carried_out(corrections, _batch())[0] == "0: open"


def test_done_lasts_until_the_hand_is_where_it_was_sent() -> None:
    corrections = Corrections(reach=0.01)
    corrections.say(0, "grasp the lid", hold="done")
    corrections.say(1, "raise the robotic arm", hold="done")
    seen = [_carried_out(corrections, _batch((x, y, 0.0))) for x, y in ((0.0, 0.0), (0.0, 0.3), (0.495, 0.0))]
    assert [row[0] for row in seen] == ["grasp the lid", "grasp the lid", "0: open"]
    assert [row[1] for row in seen] == ["raise the robotic arm"] * 3


def test_done_looks_at_the_hands_turn_too() -> None:
    corrections = Corrections(reach_degrees=5.0)
    corrections.say(0, "grasp the lid", hold="done")
    _carried_out(corrections, _batch())
    there = _batch((0.5, 0.0, 0.0))
    there[schema.STATE][0, 3:7] = torch.tensor([0.0, 0.0, 0.0698, 0.9976])  # 8 degrees
    assert _texts(corrections, there)[0] == "grasp the lid"
    there[schema.STATE][0, 3:7] = torch.tensor([0.0, 0.0, 0.0349, 0.9994])  # 4 degrees
    assert _texts(corrections, there)[0] == "0: open"


def test_done_is_given_up_after_so_many_steps() -> None:
    corrections = Corrections(max_steps=3)
    corrections.say(2, "grasp the lid", hold="done")
    seen = [_carried_out(corrections, _batch())[2] for _ in range(5)]
    assert seen == ["grasp the lid"] * 3 + ["2: lift"] * 2


def test_the_latest_words_count() -> None:
    corrections = Corrections()
    corrections.say(0, "grasp the lid", hold="done")
    said = _texts(corrections, _batch())[0]
    corrections.say(0, "release the lid")  # said while the step before is under way
    corrections.sent([a_step(0, said=said, source="person")])
    assert _carried_out(corrections, _batch())[0] == "release the lid"
    corrections.say(0, "grasp the lid")
    corrections.withdraw(0)
    corrections.withdraw(2)
    assert _texts(corrections, _batch())[0] == "0: open"


def test_a_changed_goal_holds_until_it_is_changed_again_or_the_episode_ends() -> None:
    corrections = Corrections()
    corrections.change_task(1, " stack it ")
    for _ in range(2):
        assert _carried_out(corrections, _batch()) == ["0: open", "1: stack it", "2: lift"]
    assert corrections.task(1) == "stack it" and corrections.task(0) is None
    assert corrections.goals(_batch(), 3)[1][schema.TASK] == ["open", "stack it", "lift"]
    assert corrections.goals(_batch() | {schema.TASK: "all"}, 3)[0] == ["all", "stack it", "all"]
    corrections.change_task(1, "")
    assert _texts(corrections, _batch())[1] == "1: close"
    corrections.change_task(0, "stack it")
    corrections.say(1, "grasp the lid")
    corrections.reset()
    assert _texts(corrections, _batch()) == ["0: open", "1: close", "2: lift"]


def test_words_outside_the_grammar_and_unknown_holds_are_refused_at_once() -> None:
    corrections = Corrections()
    with pytest.raises(ValueError, match="Expected a basic action"):
        corrections.say(0, "please hurry")
    with pytest.raises(ValueError, match="hold to be 'once' or 'done'"):
        corrections.say(0, "grasp the lid", hold="for ever")  # type: ignore[arg-type]
    assert _texts(corrections, _batch())[0] == "0: open"
    assert Corrections(grammar=Grammar.load("free")).say(0, "please hurry") == "please hurry"


def test_many_may_speak_while_the_loop_runs() -> None:
    corrections = Corrections(max_steps=10**6)
    stop, errors = threading.Event(), []

    def talk(row: int) -> None:
        while not stop.is_set():
            try:
                corrections.say(row, "grasp the lid", hold="done")
                corrections.change_task(row, "stack it")
                corrections.withdraw(row)
            except Exception as error:  # pragma: no cover - the test's failure
                errors.append(error)

    threads = [threading.Thread(target=talk, args=(row,)) for row in range(3)]
    for thread in threads:
        thread.start()
    seen = {text for _ in range(300) for text in _carried_out(corrections, _batch((0.5, 0.5, 0.5)))}
    stop.set()
    for thread in threads:
        thread.join()
    assert not errors
    assert seen <= {"grasp the lid", "0: open", "1: close", "2: lift", *(f"{row}: stack it" for row in range(3))}
