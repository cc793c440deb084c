import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.command.motion_gate import gated_instructions

PREVIOUS = ["grasp the cup", "grasp the cup", "", "release the cup"]


def batch_with(speeds: list[float]) -> dict:
    velocity = torch.zeros(len(speeds), len(schema.SIM_VELOCITY_NAMES))
    velocity[:, 4] = torch.tensor(speeds)
    return {
        schema.TASK: ["x"] * len(speeds),
        schema.VELOCITY: velocity,
        schema.PREVIOUS_INSTRUCTION: PREVIOUS[: len(speeds)],
    }


def test_the_instruction_stays_while_the_arm_moves_and_only_then() -> None:
    batch = batch_with([0.3, 0.05, 0.3, -0.3])
    assert gated_instructions(batch, 0.1, 7) == ["grasp the cup", None, None, "release the cup"]
    assert gated_instructions(batch, 0.01, 7) == ["grasp the cup", "grasp the cup", None, "release the cup"]


def test_a_gripper_that_moves_does_not_count() -> None:
    batch = batch_with([0.0])
    batch[schema.VELOCITY][0, 7] = 3.0
    assert gated_instructions(batch, 0.1, 7) == [None]
    assert gated_instructions(batch, 0.1, 0) == [None], "a robot without joints"


@pytest.mark.parametrize("lacking", [schema.VELOCITY, schema.PREVIOUS_INSTRUCTION])
def test_where_nothing_is_known_the_model_is_asked(lacking: str) -> None:
    batch = batch_with([0.3, 0.3])
    del batch[lacking]
    assert gated_instructions(batch, 0.1, 7) == [None, None]


def test_it_can_be_switched_off() -> None:
    assert gated_instructions(batch_with([0.3, 0.3]), None, 7) == [None, None]


def test_a_missing_task_is_named() -> None:
    with pytest.raises(ValueError, match="'task' in the batch"):
        gated_instructions({schema.VELOCITY: torch.zeros(1, len(schema.SIM_VELOCITY_NAMES))}, 0.1, 7)
