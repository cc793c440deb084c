"""Whether a gripper is open: as commanded, or as far as it gets."""

import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.datasets.commanded_gripper import command_column, gripper_opened

OPENINGS = np.array([1.0, 1.0, 0.8, 0.8, 1.0])
"""A gripper that closes on something wide and lets it go."""


@pytest.mark.parametrize("commands", [[1, 1, 0, 0, 1], [80, 100, -20, -20, 75], [0, 0, 1, 1, 0]])
def test_commands_decide_whatever_their_unit_and_sign(commands: list[float]) -> None:
    assert gripper_opened(OPENINGS, np.array(commands)).tolist() == [True, True, False, False, True]


@pytest.mark.parametrize("widest", [1.0, 0.5, 0.2])
def test_without_commands_the_greatest_opening_counts_as_open(widest: float) -> None:
    assert gripper_opened(OPENINGS * widest).tolist() == [True, True, False, False, True]
    assert gripper_opened(OPENINGS * widest, np.ones(5)).tolist() == [True, True, False, False, True]


def test_a_gripper_that_stays_closed_is_closed() -> None:
    assert not gripper_opened(np.array([0.0, 0.01, 0.02])).any()


def test_the_command_is_found_by_its_name() -> None:
    assert command_column(schema.vector(["joint_1", "gripper.pos"])) == 1
    assert command_column(schema.vector(["jaw", "joint_1"]), "jaw") == 0
    assert command_column(schema.vector(["joint_1", "jaw"])) is None
    assert command_column(schema.vector(schema.ACTION_NAMES)) is None  # the next keyframe's, not this frame's
    assert command_column({"dtype": "float32", "shape": (7,), "names": None}) is None
    assert command_column(None) is None
