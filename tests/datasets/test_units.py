"""Joints in degrees are told by how fast they turn, where their angles alone do not tell."""

import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.datasets.units import check_states
from lerobot_llakey.errors import LlakeyError

NAMES = (*schema.HAND_NAMES, "joint_1")


def states(joint: np.ndarray) -> np.ndarray:
    hand = np.tile([0.3, 0.0, 0.2, 1.0, 0.0, 0.0, 0.0, 1.0], (len(joint), 1))
    return np.column_stack((hand, joint))


def test_small_turns_in_degrees_are_refused_and_in_radians_are_not() -> None:
    radians = 0.2 * np.sin(np.linspace(0, 20, 60))
    check_states(states(radians), NAMES, np.zeros(60), 10)
    with pytest.raises(LlakeyError, match=r"joints that turn by .* a second, as in degrees"):
        check_states(states(np.rad2deg(radians)), NAMES, np.zeros(60), 10)


def test_the_step_from_one_episode_to_the_next_is_no_motion() -> None:
    joint = np.repeat([0.0, 3.0, -3.0], 4)
    check_states(states(joint), NAMES, np.repeat([0, 1, 2], 4), 30)
