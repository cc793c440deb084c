import json
import threading
from pathlib import Path

import numpy as np
import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said
from lerobot_llakey.policies.hierarchy.commanders.corrections import Corrections
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.loop import Loop


class Says(Commander):
    """Says the same for ever."""

    def __init__(self, *texts: str) -> None:
        self.texts = texts

    def ask(self, batch, rows, previous) -> list[Said]:
        return [Said(self.texts[row], "policy", 0.5) for row in rows]


def _batch(rows: int, x: float = 0.5) -> dict:
    state = torch.zeros(rows, len(schema.SIM_STATE_NAMES))
    state[:, 0], state[:, 2], state[:, 3] = x, 0.4, 1.0
    return {schema.STATE: state, schema.TASK: [f"task {row}" for row in range(rows)]}


def _loop(**settings) -> Loop:
    robot = {"state_names": list(schema.SIM_STATE_NAMES), "workspace": [list(bounds) for bounds in schema.WORKSPACE]}
    return Loop(LlakeyConfig(action=LlakeyActionConfig(device="cpu", **robot), device="cpu", **settings))


def _step(loop: Loop, commander: Commander, batch: dict) -> np.ndarray:
    loop.instruct(commander, batch)
    proposed = np.tile(np.array([0.4, 0, 0.2, 1, 0, 0, 0, 1, 0], dtype=np.float32), (len(batch[schema.STATE]), 1))
    return loop.send(commander, batch, proposed)


def test_every_step_is_on_record() -> None:
    loop, commander = _loop(repeat_threshold=0, random_move_probability=1.0), Says("grab the lid", "gibberish")
    sent = [_step(loop, commander, _batch(2, x)) for x in (0.3, 0.3, 0.4)]
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
    assert np.allclose(second.sent, sent[1][0], atol=1e-6) and second.state[:3] == pytest.approx((0.3, 0, 0.4))
    mumbled = loop.log.steps[1]
    assert [step.source for step in mumbled] == ["fallback", "previous", "previous"]
    assert all(step.unparsable and step.likelihood is None and step.said == "gibberish" for step in mumbled)
    loop.reset()
    assert loop.log.steps == [] and loop.supervisors == []


def test_the_record_can_be_written_to_a_folder(tmp_path: Path) -> None:
    loop = _loop(log_dir=str(tmp_path))
    for _ in range(2):
        _step(loop, Says("grasp the lid", "release the lid"), _batch(2))
    lines = [json.loads(line) for file in sorted(tmp_path.iterdir()) for line in file.read_text().splitlines()]
    assert sorted((line["row"], line["index"]) for line in lines) == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert {line["instruction"] for line in lines} == {"grasp the lid", "release the lid"}


def test_a_persons_words_go_through_the_loop() -> None:
    corrections = Corrections(Says("grasp the lid", "grasp the lid"))
    loop = _loop(repeat_threshold=1, random_move_probability=1.0)
    for step in range(6):
        if step == 1:
            corrections.say(1, "raise the robotic arm", hold="done")
        _step(loop, corrections, _batch(2))
    person = loop.log.steps[1]
    assert [step.source for step in person] == ["policy", *["person"] * 5]
    assert person[1].likelihood is None and not any(step.random_move for step in person)
    assert any(step.random_move for step in loop.log.steps[0])
    assert corrections.held(1) is None  # given up after five steps that did not arrive


def test_an_episode_belongs_to_one_thread() -> None:
    loop, commander = _loop(), Says("grasp the lid")
    _step(loop, commander, _batch(1))
    errors: list[Exception] = []

    def elsewhere() -> None:
        try:
            _step(loop, commander, _batch(1))
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
