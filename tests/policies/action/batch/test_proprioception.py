"""What is told about the hand and the time follows the settings."""

import pytest
import torch

from fakes_action import observation, small_config
from lerobot_llakey import schema
from lerobot_llakey.policies.action.batch.proprioception import proprioception_width, read_proprioception
from lerobot_llakey.policies.action.heads.targets import quaternion_to_angles


@pytest.mark.parametrize("told", ["pose", "gripper", "none"])
@pytest.mark.parametrize("use_timestep", [True, False])
def test_the_vector_is_as_wide_as_said(told: str, use_timestep: bool) -> None:
    config = small_config(proprioception=told, use_timestep=use_timestep)
    batch, _, _ = observation(rows=2)
    batch[schema.STEP] = torch.ones(2, 1)
    assert read_proprioception(batch, config, len(batch[schema.STATE])).vector.shape == (
        2,
        proprioception_width(config),
    )


def test_the_pose_tells_place_and_angles() -> None:
    batch, _, _ = observation(rows=2)
    hand = read_proprioception(batch, small_config(), 2)
    angles = quaternion_to_angles(batch[schema.STATE][:, schema.QUATERNION])
    assert torch.equal(hand.position, batch[schema.STATE][:, :3])
    assert torch.allclose(hand.angles, angles)
    expected = torch.cat((batch[schema.STATE][:, 7:8], angles.sin(), angles.cos()), dim=1)
    assert torch.allclose(hand.vector, expected)


def test_the_gripper_alone_tells_no_place() -> None:
    batch, _, _ = observation(rows=2)
    batch[schema.STATE][1, schema.GRIPPER] = 0.25
    hand = read_proprioception(batch, small_config(proprioception="gripper"), len(batch[schema.STATE]))
    assert hand.vector.tolist() == [[1.0], [0.25]]
    assert hand.position.isnan().all() and (hand.angles == 0).all()


def test_a_blurred_turn_blurs_nothing_else() -> None:
    batch, _, _ = observation(rows=2)
    torch.manual_seed(0)
    exact, blurred = (
        read_proprioception(batch, small_config(), len(batch[schema.STATE])),
        read_proprioception(batch, small_config(), len(batch[schema.STATE]), 7.0),
    )
    assert torch.equal(exact.position, blurred.position) and torch.equal(exact.vector[:, 0], blurred.vector[:, 0])
    off = torch.rad2deg((exact.angles - blurred.angles).abs())
    assert (off > 0.1).any() and (off < 45).all()
    expected = torch.cat((blurred.angles.sin(), blurred.angles.cos()), dim=1)
    assert torch.allclose(blurred.vector[:, 1:], expected)


def test_the_timestep_runs_from_one_to_minus_one_as_in_rvt() -> None:
    batch, _, _ = observation(rows=3)
    batch[schema.STEP] = torch.tensor([[0.0], [12.0], [24.0]])
    hand = read_proprioception(
        batch, small_config(proprioception="gripper", use_timestep=True), len(batch[schema.STATE])
    )
    assert hand.vector[:, 1].tolist() == [1.0, 0.0, -1.0]


def test_a_missing_column_is_one_sentence() -> None:
    batch, _, _ = observation(rows=1)
    batch.pop(schema.STEP, None)
    with pytest.raises(ValueError, match=r"Expected observation\.step .* policy\.use_timestep is on, got none; add"):
        read_proprioception(batch, small_config(use_timestep=True), 1)
    del batch[schema.STATE]
    with pytest.raises(ValueError, match=r"Expected observation\.state in the batch, got .*; add it"):
        read_proprioception(batch, small_config(), 1)
