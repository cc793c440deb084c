"""The answers of a training sample are its own, and move with the scene."""

import math

import pytest
import torch

from fakes import fake_keysteps
from fakes_action import observation
from lerobot_llakey import schema
from lerobot_llakey.policies.action.batch.augmentation import RigidMotion
from lerobot_llakey.policies.action.batch.labels import moved, read_labels

WORKSPACE = torch.tensor(schema.WORKSPACE)


def test_every_label_is_the_rows_own_actions(tmp_path) -> None:
    # NVlabs/RVT issue 91: its replay stores the collision flag of another frame.
    dataset = fake_keysteps(tmp_path / "data", episodes=1, frames=6)
    actions = torch.stack([row[schema.ACTION] for row in dataset])
    labels = read_labels(actions, WORKSPACE)
    assert labels.collision.tolist() == [bool(row[schema.ACTION][8]) for row in dataset]
    assert labels.gripper.tolist() == [bool(row[schema.ACTION][7]) for row in dataset]
    # In the fakes the flag changes with the segment, on the very frame at which the action does.
    assert labels.collision.tolist() == [False] * 3 + [True] * 3


def test_the_flag_is_read_from_its_own_column() -> None:
    actions = torch.zeros(4, schema.ACTION_DIM)
    actions[:, :3], actions[:, 6] = 0.3, 1.0
    actions[:, schema.GRIPPER] = torch.tensor([0.0, 0.0, 1.0, 1.0])
    actions[:, schema.IGNORE_COLLISION] = torch.tensor([0.0, 1.0, 0.0, 1.0])
    labels = read_labels(actions, WORKSPACE)
    assert labels.collision.tolist() == [False, True, False, True]
    assert labels.gripper.tolist() == [False, False, True, True]


def test_a_keyframe_outside_the_workspace_is_named() -> None:
    actions = torch.zeros(2, schema.ACTION_DIM)
    actions[:, 6], actions[1, 2] = 1.0, 2.0
    with pytest.raises(ValueError, match=r"got \[0.0, 0.0, 2.0\] in action at batch row 1"):
        read_labels(actions, WORKSPACE)


def test_cameras_hand_and_labels_move_together() -> None:
    batch, _, _ = observation(rows=2)
    labels = read_labels(batch[schema.ACTION], WORKSPACE)
    motion = RigidMotion(torch.tensor([math.pi / 2] * 2), torch.tensor([[0.5, 0.0, 0.0]] * 2), torch.zeros(2, 3))
    batch[schema.STATE][:, schema.POSITION] = labels.position
    batch[schema.STATE][:, schema.QUATERNION] = labels.quaternion
    after, shifted = moved(batch, labels, motion, ["front"], range(8))
    x, y, z = labels.position.unbind(1)
    assert torch.allclose(shifted.position, torch.stack((0.5 - y, x - 0.5, z), dim=1), atol=1e-6)
    assert torch.allclose(after[schema.STATE][:, schema.POSITION], shifted.position, atol=1e-6)
    assert torch.allclose(after[schema.STATE][:, schema.QUATERNION], shifted.quaternion, atol=1e-6)
    assert torch.equal(after[schema.STATE][:, schema.GRIPPER :], batch[schema.STATE][:, schema.GRIPPER :])
    assert torch.allclose(shifted.heading, motion.yaw)
    key = schema.extrinsics_key("front")
    ex, ey = batch[key][0, :2]
    assert torch.allclose(after[key][0, :2], torch.stack((0.5 - ey, ex - 0.5)), atol=1e-6)
    # Nothing of the given batch has changed.
    assert torch.equal(batch[schema.STATE][:, schema.POSITION], labels.position)
