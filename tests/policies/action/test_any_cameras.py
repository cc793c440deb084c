"""The policy reads cameras and state by name: what else a batch holds, and in which order, changes nothing."""

from pathlib import Path

import pytest
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from torch.utils.data import DataLoader

from fakes import fake_keysteps
from fakes_action import observation, small_config
from lerobot_llakey import schema
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy

PARTS = (schema.image_key, schema.depth_key, schema.intrinsics_key, schema.extrinsics_key)


def make(**settings) -> LlakeyActionPolicy:
    torch.manual_seed(0)
    return LlakeyActionPolicy(small_config(**settings)).eval()


@pytest.mark.parametrize("cameras", [["wrist", "front"], ["front", "wrist"], ["right_shoulder"]])
def test_a_subset_of_the_cameras_is_as_good_as_a_batch_with_just_these(cameras: list[str]) -> None:
    batch, _, _ = observation(rows=2)
    policy = make(cameras=cameras)
    others = {part(camera) for camera in set(schema.CAMERAS) - set(cameras) for part in PARTS}
    fewer = {key: value for key, value in batch.items() if key not in others}
    expected = policy.select_action(fewer)
    assert torch.equal(policy.select_action(batch), expected)
    assert torch.equal(policy.select_action(dict(reversed(batch.items()))), expected)


def test_the_states_numbers_are_found_by_name_and_either_sign_of_a_quaternion_is_the_same() -> None:
    batch, _, _ = observation(rows=2)
    names, expected = list(schema.SIM_STATE_NAMES), make().select_action(batch)
    turned = [*names[8:], *names[7::-1]]
    other = batch | {schema.STATE: batch[schema.STATE][:, [names.index(name) for name in turned]]}
    assert torch.equal(make(state_names=turned).select_action(other), expected)
    poses = (schema.STATE, *map(schema.extrinsics_key, schema.CAMERAS))
    negated = {
        key: batch[key] * torch.where((torch.arange(batch[key].shape[1]) - 4.5).abs() < 2, -1, 1) for key in poses
    }
    assert torch.equal(make().select_action(batch | negated), expected)


def test_a_hand_without_gripper_or_joints_counts_as_open() -> None:
    batch, _, _ = observation(rows=2)
    batch[schema.STATE][:, schema.GRIPPER] = 1.0
    bare = batch | {schema.STATE: batch[schema.STATE][:, :7]}
    policy = make(state_names=list(schema.POSE_NAMES))
    assert torch.equal(policy.select_action(bare), make().select_action(batch))


def decisions(dataset: LeRobotDataset, cameras: list[str]) -> tuple[torch.Tensor, torch.Tensor]:
    """What a fresh policy for a dataset does for its first frames (6, 9), and its losses (6,)."""
    torch.manual_seed(0)
    config = small_config(cameras=cameras, workspace="auto", state_names=[])
    policy = LlakeyActionPolicy(config, dataset_meta=dataset.meta).eval()
    batch = next(iter(DataLoader(dataset, batch_size=6)))
    losses, _ = policy.forward(batch, reduction="none")
    return policy.select_action(batch | {schema.INSTRUCTION: ["grasp the red block"] * 6}), losses.detach()


def test_two_cameras_of_a_dataset_of_four_are_as_good_as_a_dataset_of_these_two(tmp_path: Path) -> None:
    others = [part(camera) for camera in ("left_shoulder", "right_shoulder") for part in PARTS]
    four, two = fake_keysteps(tmp_path / "four"), fake_keysteps(tmp_path / "two", without=others)
    assert schema.cameras_of(two.meta.features) == ("front", "wrist")
    of_four, of_two = decisions(four, ["wrist", "front"]), decisions(two, ["wrist", "front"])
    assert all(torch.equal(first, second) for first, second in zip(of_four, of_two, strict=True))
    assert not torch.equal(of_four[1], decisions(four, ["left_shoulder"])[1])
