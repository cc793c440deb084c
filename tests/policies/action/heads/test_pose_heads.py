"""Poses from features: what is known of every head, and of the one with independent bins."""

import math

import pytest
import torch
from scipy.spatial.transform import Rotation
from torch import Tensor

from lerobot_llakey import geometry
from lerobot_llakey.policies.action.heads.pose_heads import BinsHead, PoseHead, bins_loss, bins_quaternion, shift_bins
from lerobot_llakey.policies.action.heads.rotation_sequential import SequentialBinsHead
from lerobot_llakey.policies.action.heads.rotation_sixd import SixDHead
from lerobot_llakey.policies.action.heads.targets import quaternion_to_angles

INPUTS = 12


def make_head(kind: str, frames: tuple[str, ...] = ("view", "hand", "base")) -> PoseHead:
    torch.manual_seed(0)
    if kind == "sixd":
        return SixDHead(INPUTS, 16, frames)
    return (BinsHead if kind == "bins" else SequentialBinsHead)(INPUTS, 72, 16, frames)


def quaternions(count: int) -> Tensor:
    drawn = Rotation.from_euler("zyx", torch.rand(count, 3, generator=torch.Generator().manual_seed(1)).numpy())
    return torch.from_numpy((drawn * Rotation.from_quat(geometry.top_down())).as_quat()).float()


def turned(quaternion: Tensor, yaw: float) -> Tensor:
    return torch.from_numpy((Rotation.from_euler("z", yaw) * Rotation.from_quat(quaternion.detach())).as_quat()).float()


def degrees_between(first: Tensor, second: Tensor) -> Tensor:
    cosine = (first.double() * second.double()).sum(-1).abs().clamp(max=1.0)
    return torch.rad2deg(2 * cosine.arccos())


KINDS = pytest.mark.parametrize("kind", ["bins", "sequential_bins", "sixd"])


@KINDS
def test_gripper_and_collision_are_logits_and_the_rotation_a_unit_quaternion(kind: str) -> None:
    head = make_head(kind)
    output = head(torch.randn(5, INPUTS), torch.zeros(5, 3), torch.zeros(5))
    assert output.gripper.shape == output.collision.shape == (5, 2)
    quaternion = head.quaternion(output)
    assert torch.allclose(quaternion.norm(dim=1), torch.ones(5), atol=1e-5) and (quaternion[:, 3] >= 0).all()
    assert head.rotation_loss(output, quaternions(5)).shape == (5,)


@KINDS
@pytest.mark.parametrize("frames", [("hand",), ("base",), ("hand", "base")])
def test_what_is_told_relative_to_hand_or_base_turns_with_them(kind: str, frames: tuple[str, ...]) -> None:
    head, features, hand = make_head(kind, frames), torch.randn(6, INPUTS), quaternions(6)
    yaw = math.radians(35.0)  # seven bins
    before = head.quaternion(head(features, quaternion_to_angles(hand), torch.zeros(6)))
    after = head(features, quaternion_to_angles(turned(hand, yaw)), torch.full((6,), yaw))
    assert degrees_between(head.quaternion(after), turned(before, yaw)).max() < 0.2
    still = head(features, quaternion_to_angles(hand), torch.zeros(6))
    assert degrees_between(head.quaternion(still), turned(before, yaw)).min() > 30


@KINDS
def test_the_loss_is_the_same_once_hand_base_and_truth_are_turned_together(kind: str) -> None:
    head, features, hand, truth = (
        make_head(kind, ("hand", "base")),
        torch.randn(6, INPUTS),
        quaternions(6),
        quaternions(6),
    )
    yaw = math.radians(-40.0)
    losses = []
    for angle in (0.0, yaw):
        true = turned(truth, angle)
        output = head(features, quaternion_to_angles(turned(hand, angle)), torch.full((6,), angle), true)
        losses.append(head.rotation_loss(output, true))
    assert torch.allclose(losses[0], losses[1], atol=1e-3)


@KINDS
def test_a_head_learns_rotations_from_features(kind: str) -> None:
    head, truth = make_head(kind), quaternions(4)
    features = torch.randn(4, INPUTS)
    optimiser = torch.optim.Adam(head.parameters(), lr=1e-2)
    for _ in range(120):
        output = head(features, torch.zeros(4, 3), torch.zeros(4), truth)
        optimiser.zero_grad()
        head.rotation_loss(output, truth).mean().backward()
        optimiser.step()
    predicted = head.quaternion(head(features, torch.zeros(4, 3), torch.zeros(4)))
    assert degrees_between(predicted, truth).max() < 7.6  # what three bins of 5 degrees allow


@pytest.mark.parametrize(("present", "expected"), [(0, 3), (10, 13), (70, 1), (-5, 70)])
def test_relative_votes_turn_with_the_present_angle(present: int, expected: int) -> None:
    relative = torch.zeros(1, 72)
    relative[0, 3] = 1.0
    shifted = shift_bins(relative, torch.tensor([math.radians(5.0 * present + 0.01)]))
    assert shifted.argmax().item() == expected
    assert shifted.sum().item() == pytest.approx(1.0, abs=1e-5)


def test_relative_votes_between_bins_are_shared() -> None:
    relative = torch.zeros(1, 72)
    relative[0, 0] = 1.0
    shifted = shift_bins(relative, torch.tensor([math.radians(11.0)]))[0]
    assert shifted[2].item() == pytest.approx(0.8, abs=1e-3)
    assert shifted[3].item() == pytest.approx(0.2, abs=1e-3)


def test_votes_turn_with_the_hand_and_with_the_base() -> None:
    head = BinsHead(4, 72, 8)
    votes = torch.zeros(3, 3, 72)
    votes[1, 1, 4], votes[2, 0, 7] = 5.0, 5.0  # the second angle from the hand, the first from the base
    torch.nn.init.zeros_(head.votes.weight)
    head.votes.bias.data = votes.flatten()
    present = torch.deg2rad(torch.tensor([[0.0, 25.0, 0.0]]))
    angles = head(torch.randn(1, 4), present, torch.deg2rad(torch.tensor([15.0]))).rotation
    assert angles[0, 0].argmax().item() == 10
    assert angles[0, 1].argmax().item() == 9


def test_the_loss_of_bins_is_least_at_the_truth() -> None:
    truth = quaternions(3)
    logits = torch.zeros(3, 3, 72)
    assert torch.allclose(bins_loss(logits, truth), torch.full((3,), 3 * math.log(72)))
    bins = (quaternion_to_angles(truth) * 72 / (2 * math.pi)).round().long() % 72
    logits.scatter_(2, bins[..., None], 20.0)
    assert bins_loss(logits, truth).max() < 1e-4
    assert degrees_between(bins_quaternion(logits), truth).max() < 7.6
