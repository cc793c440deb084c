import math

import pytest
import torch

from fakes import fake_keysteps
from lerobot_llakey import geometry, schema
from lerobot_llakey.evaluation.keyframe_accuracy import keyframe_accuracy, sample_errors


class Copycat:
    """Repeats the recorded action, 15 mm too high where told to grasp."""

    def reset(self):
        pass

    def select_action(self, batch):
        action = batch[schema.ACTION].clone()
        for row, text in enumerate(batch[schema.INSTRUCTION]):
            action[row, 2] += 0.015 * text.startswith("grasp")
        return action


def quaternions(*yaws):
    return torch.stack([torch.from_numpy(geometry.top_down(yaw)).float() for yaw in yaws])


def test_each_measure_looks_at_its_own_columns():
    target = torch.cat((torch.zeros(1, 3), quaternions(0.0), torch.tensor([[1.0, 0.0]])), dim=1).repeat(4, 1)
    action = target.clone()
    action[1, 0] = 0.015
    action[2, schema.QUATERNION] = quaternions(math.radians(7))[0]
    action[3, schema.GRIPPER] = 0.0
    right = sample_errors(action, target)
    assert right["position_within_1cm"].tolist() == [1, 0, 1, 1]
    assert right["position_within_2cm"].tolist() == [1, 1, 1, 1]
    assert right["rotation_within_5deg"].tolist() == [1, 1, 0, 1]
    assert right["rotation_within_10deg"].tolist() == [1, 1, 1, 1]
    assert right["gripper_right"].tolist() == [1, 1, 1, 0]
    assert right["collision_right"].tolist() == [1, 1, 1, 1]


def test_accuracy_is_split_by_verb(tmp_path):
    dataset = fake_keysteps(tmp_path / "data", episodes=2, frames=6)
    accuracy = keyframe_accuracy(Copycat(), dataset, batch_size=5)
    assert sorted(accuracy) == ["all", "grasp", "move"]
    assert accuracy["move"]["samples"] == accuracy["grasp"]["samples"] == 6
    assert accuracy["move"]["position_within_1cm"] == 1.0
    assert accuracy["grasp"]["position_within_1cm"] == 0.0
    assert accuracy["all"]["position_within_1cm"] == 0.5
    assert accuracy["grasp"]["position_error_mm"] == pytest.approx(15.0, abs=0.1)
    assert keyframe_accuracy(Copycat(), dataset, num_samples=4)["all"]["samples"] == 4


def test_a_dataset_without_instructions_is_refused(tmp_path):
    dataset = fake_keysteps(tmp_path / "data", episodes=1, frames=2, without=(schema.INSTRUCTION,))
    with pytest.raises(ValueError, match="without instruction columns"):
        keyframe_accuracy(Copycat(), dataset)
    with pytest.raises(ValueError, match="empty"):
        keyframe_accuracy(Copycat(), torch.utils.data.TensorDataset(torch.zeros(0, 1)))
