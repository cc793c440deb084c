import math
from typing import Any

import pytest
import torch

from fakes_steps import a_step
from lerobot_llakey import schema
from lerobot_llakey.policies.command.decoding.answer import Answer
from lerobot_llakey.policies.hierarchy.commanders import (
    ListCommander,
    OracleCommander,
    PolicyCommander,
    TaskCommander,
    build_commander,
    take_rows,
)
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.decision import Said


def test_takes_rows_of_everything_that_has_rows() -> None:
    batch = {
        schema.STATE: torch.arange(45.0).reshape(3, 15),
        schema.TASK: ["a", "b", "c"],
        "scalar": torch.tensor(7.0),
        "shared": torch.zeros(2, 4),
        "info": None,
    }
    taken = take_rows(batch, [2, 0])
    assert torch.equal(taken[schema.STATE], batch[schema.STATE][[2, 0]])
    assert taken[schema.TASK] == ["c", "a"]
    assert taken["scalar"] is batch["scalar"] and taken["shared"] is batch["shared"] and taken["info"] is None


def test_builds_whom_the_settings_name(make_tiny) -> None:
    for name, kind in (("oracle", OracleCommander), ("task", TaskCommander)):
        assert type(build_commander(LlakeyConfig(device="cpu", commander=name), None)) is kind
    config = LlakeyConfig(device="cpu", commander="list", instructions=["grasp the lid"])
    commander = build_commander(config, None)
    assert isinstance(commander, ListCommander) and commander.instructions == ["grasp the lid"]
    policy = make_tiny()
    assert isinstance(policy.loop.commander, PolicyCommander)
    assert policy.loop.commander.command is policy.command


def test_a_command_policy_that_acts_by_itself_is_refused(make_tiny) -> None:
    policy = make_tiny()
    policy.command.config.target = "action"
    with pytest.raises(ValueError, match="target='instruction', got target='action'"):
        build_commander(policy.config, policy.command)


class Dice:
    """A command policy that says a number: its row's state."""

    def __init__(self) -> None:
        self.batches: list[dict[str, Any]] = []

    def reset(self) -> None:
        self.batches.clear()

    def answer(self, batch) -> list[Answer]:
        self.batches.append(batch)
        values = [row[0].item() for row in batch[schema.STATE]]
        return [Answer(f"{value:.6f}", math.nan if value == 0 else 0.25) for value in values]


def _batch(rows: int) -> dict[str, Any]:
    return {schema.STATE: torch.arange(rows)[:, None].repeat(1, 15).float(), schema.TASK: ["t"] * rows}


def test_asks_for_the_rows_with_what_was_said_before() -> None:
    commander = PolicyCommander(dice := Dice())
    said = commander.ask(_batch(3), [2, 1], ["before", ""])
    assert said == [Said("2.000000", "policy", 0.25), Said("1.000000", "policy", 0.25)]
    assert dice.batches[0][schema.PREVIOUS_INSTRUCTION] == ["before", ""]
    assert dice.batches[0][schema.TASK] == ["t", "t"]
    assert commander.ask(_batch(1), [0], [""])[0].likelihood is None


def test_passes_on_what_the_environment_says_to_the_rows_asked_for() -> None:
    texts = ["grasp the lid", "open the lid", "raise the robotic arm"]
    said = OracleCommander().ask({schema.ORACLE_INSTRUCTION: texts}, [2, 0], ["", ""])
    assert said == [Said("raise the robotic arm", "oracle"), Said("grasp the lid", "oracle")]


def test_an_environment_without_an_expert_is_named() -> None:
    with pytest.raises(ValueError, match=r"Expected 'observation.oracle_instruction'.*--env.oracle_instructions=true"):
        OracleCommander().ask({}, [0], [""])


def test_says_the_skill_instruction() -> None:
    commander = TaskCommander()
    assert commander.ask({schema.TASK: ["open it", "close it"]}, [1], [""]) == [Said("close it", "task")]
    assert commander.ask({schema.TASK: "open it"}, [0, 1], ["", ""]) == [Said("open it", "task")] * 2


def test_a_missing_task_is_named() -> None:
    with pytest.raises(ValueError, match="Expected 'task' in the batch, got"):
        TaskCommander().ask({}, [0], [""])


def _listed(commander: ListCommander, rows: list[int]) -> list[str]:
    return [said.text for said in commander.ask({}, rows, [""] * len(rows))]


def test_gives_one_a_step_to_each_row_and_the_last_one_for_ever() -> None:
    commander = ListCommander(["a", "b", "c"])
    assert _listed(commander, [0, 1]) == _listed(commander, [0, 1]) == ["a", "a"]  # asking uses nothing up
    commander.sent([a_step(0), a_step(1, random_move=True)])
    assert _listed(commander, [1, 0]) == ["a", "b"]
    for _ in range(5):
        commander.sent([a_step(0), a_step(1, source="person")])
    assert _listed(commander, [0, 1]) == ["c", "a"]
    commander.reset()
    assert _listed(commander, [0, 1]) == ["a", "a"]
