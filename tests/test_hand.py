"""The hand is found among a state's numbers by their names."""

import numpy as np
import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.hand import further_columns, hand_columns, read_hand


def test_the_simulators_state_begins_with_the_hand() -> None:
    assert hand_columns(schema.SIM_STATE_NAMES) == tuple(range(8))
    assert further_columns(schema.SIM_STATE_NAMES) == tuple(range(8, 15))


@pytest.mark.parametrize("prefix", ["", "ee.", "ee_", "tcp.", "Hand_", "end_effector."])
def test_any_order_and_usual_prefixes_and_suffixes_are_read(prefix: str) -> None:
    names = [
        "gripper.pos",
        "shoulder_pan.pos",
        *(f"{prefix}{name}" for name in ("qw", "qx", "qy", "qz", "x", "y", "z")),
    ]
    columns = hand_columns(names)
    assert columns == (6, 7, 8, 3, 4, 5, 2, 0)
    assert further_columns(names) == (1,)
    states = np.arange(18.0).reshape(2, 9)
    np.testing.assert_array_equal(read_hand(states, columns), states[:, list(columns)])
    assert torch.equal(read_hand(torch.tensor(states), columns), torch.tensor(states)[:, list(columns)])


def test_a_hand_without_a_gripper_counts_as_open() -> None:
    columns = hand_columns(schema.POSE_NAMES)
    assert len(columns) == 7
    states = np.zeros((2, 3, 7), dtype=np.float32)
    for hand in (read_hand(states, columns), read_hand(torch.tensor(states), columns).numpy()):
        assert hand.shape == (2, 3, 8) and hand.dtype == np.float32
        assert (hand[..., schema.GRIPPER] == 1).all() and (hand[..., :7] == 0).all()


@pytest.mark.parametrize(
    ("names", "came"),
    [
        ([], "'x' among the names of observation.state, got only numbers without names"),
        (["x", "y", "z", "qx", "qy", "qz", "gripper"], "'qw' .* got only x, y, z, qx, qy, qz, gripper"),
        ([*schema.POSE_NAMES, "ee_x"], "'x' .* got it twice"),
    ],
)
def test_a_pose_that_is_not_whole_is_named(names: list[str], came: str) -> None:
    with pytest.raises(LlakeyError, match=came):
        hand_columns(names)
