import json
import threading
from pathlib import Path

import numpy as np
import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.hierarchy.commanders import Commander
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.decision import Said
from lerobot_llakey.policies.hierarchy.loop import Loop, episode_key
from lerobot_llakey.policies.hierarchy.step_log import Step


class Says(Commander):
    """Says the same for ever, and notes which rows it was asked for."""

    def __init__(self, *texts: str) -> None:
        self.texts = texts
        self.asked: list[list[int]] = []

    def ask(self, batch, rows, previous) -> list[Said]:
        self.asked.append(list(rows))
        return [Said(self.texts[row], "policy", 0.5) for row in rows]


def _batch(rows: int, x: float = 0.5) -> dict:
    state = torch.zeros(rows, len(schema.SIM_STATE_NAMES))
    state[:, 0], state[:, 2], state[:, 3] = x, 0.4, 1.0
    return {schema.STATE: state, schema.TASK: [f"task {row}" for row in range(rows)]}


def _loop(*texts: str, **settings) -> Loop:
    robot = {"state_names": list(schema.SIM_STATE_NAMES), "workspace": [list(bounds) for bounds in schema.WORKSPACE]}
    config = LlakeyConfig(action=LlakeyActionConfig(device="cpu", **robot), device="cpu", **settings)
    return Loop(config, Says(*texts))


def _step(loop: Loop, batch: dict) -> list[Step]:
    proposed = np.tile(np.array([0.4, 0, 0.2, 1, 0, 0, 0, 1, 0], dtype=np.float32), (len(batch[schema.STATE]), 1))
    return loop.commit(loop.decide(batch), proposed)


def test_every_step_is_on_record() -> None:
    loop = _loop("grab the lid", "gibberish", repeat_threshold=0, random_move_probability=1.0)
    sent = [_step(loop, _batch(2, x)) for x in (0.3, 0.3, 0.4)]
    first, second, third = loop.log.steps[0]
    assert (first.said, first.instruction, first.source, first.likelihood) == (
        "grab the lid",
        "grasp the lid",
        "policy",
        0.5,
    )
    assert (first.index, first.row, first.task, first.unparsable) == (0, 0, "task 0", False)
    assert [step.moved for step in (first, second, third)] == [None, False, True]
    assert [step.random_move for step in (first, second, third)] == [False, True, True]
    assert [step.repeats for step in (first, second, third)] == [0, 1, 1]
    assert first.proposed[schema.GRIPPER] == 1.0 and first.sent[schema.GRIPPER] == 0.0
    assert second is sent[1][0] and second.state[:3] == pytest.approx((0.3, 0, 0.4))
    mumbled = loop.log.steps[1]
    assert [step.source for step in mumbled] == ["fallback", "previous", "previous"]
    assert all(step.unparsable and step.likelihood is None and step.said == "gibberish" for step in mumbled)
    loop.reset()
    assert loop.log.steps == [] and loop.supervisors == []


def test_the_record_can_be_written_to_a_folder(tmp_path: Path) -> None:
    loop = _loop("grasp the lid", "release the lid", log_dir=str(tmp_path))
    for _ in range(2):
        _step(loop, _batch(2))
    lines = [json.loads(line) for file in sorted(tmp_path.iterdir()) for line in file.read_text().splitlines()]
    assert sorted((line["row"], line["index"]) for line in lines) == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert {line["instruction"] for line in lines} == {"grasp the lid", "release the lid"}


def test_a_persons_words_go_through_the_loop() -> None:
    loop = _loop("grasp the lid", "grasp the lid", repeat_threshold=1, random_move_probability=1.0)
    for step in range(6):
        if step == 1:
            loop.corrections.say(1, "raise the robotic arm", hold="done")
        _step(loop, _batch(2))
    person = loop.log.steps[1]
    assert [step.source for step in person] == ["policy", *["person"] * 5]
    assert person[1].likelihood is None and not any(step.random_move for step in person)
    assert any(step.random_move for step in loop.log.steps[0])
    assert loop.commander.asked == [[0, 1], *[[0]] * 5]  # type: ignore[attr-defined]
    assert loop.decide(_batch(2)).choices[1].source == "policy"  # given up after five steps that did not arrive


def test_deciding_changes_nothing_and_asks_once_what_is_known() -> None:
    loop = _loop("grab the lid", "gibberish")
    _step(loop, _batch(2))
    before = [vars(row).copy() for row in loop.supervisors]
    decision = loop.decide(_batch(2, 0.9))
    loop.corrections.change_task(0, "another goal")
    other = loop.decide(_batch(2, 0.9), known=decision)
    loop.corrections.change_task(0, "")
    assert loop.decide(_batch(2, 0.9), known=other).choices == decision.choices
    assert loop.commander.asked == [[0, 1], [0, 1], [0]]  # type: ignore[attr-defined]
    assert [vars(row) for row in loop.supervisors] == before and len(loop.log.steps[0]) == 1
    assert other.goals == other.batch[schema.TASK] == ["another goal", "task 1"]
    assert decision.batch[schema.INSTRUCTION] == ["grasp the lid", "raise the robotic arm"]


def test_an_episode_belongs_to_one_thread() -> None:
    loop = _loop("grasp the lid")
    _step(loop, _batch(1))
    errors: list[Exception] = []

    def elsewhere() -> None:
        try:
            _step(loop, _batch(1))
        except ValueError as error:
            errors.append(error)

    for expected in (1, 1):
        thread = threading.Thread(target=elsewhere)
        thread.start()
        thread.join()
        assert len(errors) == expected
        loop.reset()  # a new episode may begin in any thread
    assert "Expected all steps of an episode from one thread" in str(errors[0])
    assert "--env.max_parallel_tasks=1" in str(errors[0])


def _first() -> dict:
    return {
        schema.STATE: torch.arange(30.0).reshape(2, 15),
        schema.TASK: ["open the drawer", "close the jar"],
        schema.image_key("front"): torch.linspace(0, 1, 2 * 3 * 4 * 4).reshape(2, 3, 4, 4),
    }


def _turned_round() -> dict:
    return {key: value.flip(0) if isinstance(value, torch.Tensor) else value[::-1] for key, value in _first().items()}


def test_does_not_depend_on_the_place_in_the_first() -> None:
    assert episode_key(_first(), 0) == episode_key(_turned_round(), 1) != episode_key(_first(), 1)
    assert 0 <= episode_key(_first(), 0) < 2**64


def test_depends_on_goal_state_and_pictures() -> None:
    keys = {episode_key(_first(), 0)}
    for key in (schema.STATE, schema.image_key("front")):
        batch = _first()
        batch[key].view(-1)[3] += 0.01
        keys.add(episode_key(batch, 0))
    keys.add(episode_key(_first() | {schema.TASK: "open the door"}, 0))
    assert len(keys) == 4
