"""What is handed in and handed back keeps to the data contract."""

import math

import pytest
import torch
from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.batch import (
    check_actions,
    check_at_least_zero,
    check_finite,
    check_poses,
    read_images,
)

KEY = schema.image_key("front")


def states() -> Tensor:
    rows = torch.zeros(3, schema.HAND_DIM)
    rows[:, :3], rows[:, 6], rows[:, 7] = 0.3, 1.0, 1.0
    return rows


def test_images_in_bytes_are_divided_and_floats_are_kept() -> None:
    images = torch.randint(0, 256, (2, 3, 4, 4), dtype=torch.uint8)
    assert torch.equal(read_images({KEY: images}, [KEY])[0], images.float() / 255)
    assert torch.equal(read_images({KEY: images.float() / 255}, [KEY])[0], images.float() / 255)


@pytest.mark.parametrize(
    ("image", "said"),
    [
        (torch.full((2, 3, 4, 4), 200.0), "colours from 0 to 1 in observation.images.front, got 200 to 200"),
        (torch.full((2, 3, 4, 4), -1.7), "colours from 0 to 1"),
        (torch.full((2, 3, 4, 4), math.nan), "colours from 0 to 1 .* got nan to nan in batch row 0"),
        (torch.full((2, 3, 4, 4), 200), "in floats from 0 to 1 or in uint8, got int64"),
        (torch.zeros(2, 4, 4, 3), r"shape \(batch, 3, height, width\), got \(2, 4, 4, 3\)"),
    ],
)
def test_other_images_are_refused(image: Tensor, said: str) -> None:
    with pytest.raises(LlakeyError, match=said):
        read_images({KEY: image}, [KEY])


def test_a_missing_image_is_named() -> None:
    with pytest.raises(LlakeyError, match=r"got observation\.images\.wrist; add observation\.images\.front"):
        read_images({schema.image_key("wrist"): torch.zeros(1, 3, 4, 4)}, [KEY])


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [
        (0, math.nan, "a position in metres"),
        (2, math.inf, "a position in metres"),
        (1, 412.0, "a position in metres"),
        (6, 0.0, "a unit quaternion"),
        (6, 1e-20, "a unit quaternion"),
        (6, 100.0, "a unit quaternion"),
        (4, math.nan, "a unit quaternion"),
        (4, math.inf, "a unit quaternion"),
        (7, math.nan, "a gripper from 0"),
        (7, 100.0, "a gripper from 0"),
        (7, -1.0, "a gripper from 0"),
    ],
)
def test_what_is_no_pose_is_refused_with_key_and_row(column: int, value: float, said: str) -> None:
    rows = states()
    check_poses(schema.STATE, rows)
    rows[1, column] = value
    with pytest.raises(LlakeyError, match=rf"Expected {said}.* in observation\.state, got \[.*\] in batch row 1;"):
        check_poses(schema.STATE, rows)


def test_poses_may_be_rounded() -> None:
    rows = states()
    rows[:, 3:7] = torch.tensor([0.7, 0.7, 0.0, 0.14])
    check_poses(schema.STATE, rows)


@pytest.mark.parametrize("value", [math.nan, math.inf, -1.0])
def test_steps_and_velocities_make_sense(value: float) -> None:
    with pytest.raises(LlakeyError, match=r"Expected observation\.step of 0 or more, got .* in batch row 1"):
        check_at_least_zero(schema.STEP, torch.tensor([[0.0], [value]]))
    check_finite(schema.VELOCITY, torch.tensor([[-1.0, 0.0]]))
    with pytest.raises(LlakeyError, match=r"finite numbers in observation\.velocity.* batch row 0"):
        check_finite(schema.VELOCITY, torch.tensor([[0.0, math.nan]]))


def test_an_action_that_is_not_finite_goes_no_further() -> None:
    good = torch.ones(2, schema.ACTION_DIM)
    assert check_actions(good) is good
    bad = good.clone()
    bad[1, 4] = math.nan
    with pytest.raises(LlakeyError, match=r"answer with finite numbers, got .*nan.* in batch row 1; its weights"):
        check_actions(bad)
