import math

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from lerobot_llakey import geometry
from lerobot_llakey.policies.action.heads.targets import (
    angle_bins,
    angles_to_quaternion,
    bin_angles,
    heatmap_target,
    quaternion_to_angles,
    rotation_target,
    shrinking_sigma,
)


def angle_between(first, second):
    return (Rotation.from_quat(first).inv() * Rotation.from_quat(second)).magnitude()


def test_angles_are_inverted_exactly():
    quaternions = torch.from_numpy(Rotation.random(500, random_state=0).as_quat())
    back = angles_to_quaternion(quaternion_to_angles(quaternions))
    assert angle_between(quaternions.numpy(), back.numpy()).max() < 1e-6


@pytest.mark.parametrize("yaw", np.deg2rad([-85, -40, 0, 5, 60]))
def test_grasps_from_above_and_level_ones_are_far_from_singular(yaw):
    level = (Rotation.from_euler("z", yaw) * Rotation.from_euler("y", np.pi / 2)).as_quat()
    for quaternion in (geometry.top_down(yaw), geometry.canonical_quaternion(level)):
        angles = quaternion_to_angles(torch.from_numpy(quaternion))
        assert abs(angles[1]) < math.radians(46)
        assert math.isclose(angles[0], yaw, abs_tol=1e-6)


def test_a_turn_about_z_only_shifts_the_first_angle():
    quaternion = Rotation.from_quat(geometry.top_down(0.3)) * Rotation.from_euler("xyz", [0.1, 0.2, 0.3])
    before = quaternion_to_angles(torch.from_numpy(quaternion.as_quat()))
    after = quaternion_to_angles(torch.from_numpy((Rotation.from_euler("z", 0.4) * quaternion).as_quat()))
    assert torch.allclose(after - before, torch.tensor([0.4, 0.0, 0.0], dtype=before.dtype), atol=1e-6)


def test_bins_are_half_a_bin_from_the_truth_at_most_and_wrap():
    angles = torch.linspace(-math.pi, math.pi, 1001)
    error = bin_angles(angle_bins(angles, 72), 72) - angles
    error = torch.atan2(error.sin(), error.cos())
    assert error.abs().max() <= math.radians(2.5) + 1e-5
    assert angle_bins(torch.tensor([math.pi / 2, -math.pi / 2, 0.0]), 72).tolist() == [18, 54, 0]


def test_rotations_survive_binning_to_a_few_degrees():
    quaternions = torch.from_numpy(Rotation.random(500, random_state=1).as_quat())
    binned = bin_angles(angle_bins(quaternion_to_angles(quaternions), 72), 72).double()
    worst = angle_between(quaternions.numpy(), angles_to_quaternion(binned).numpy()).max()
    assert worst < math.radians(7.6)


def test_heat_is_a_truncated_distribution_around_the_point():
    point = torch.tensor([[0.31, 0.72]])
    heatmap = heatmap_target(point, 50, 2.0)
    assert heatmap.sum().item() == pytest.approx(1.0, abs=1e-5)
    axis = (torch.arange(50) + 0.5) / 50
    mean = torch.stack(((heatmap[0].sum(1) * axis).sum(), (heatmap[0].sum(0) * axis).sum()))
    assert torch.allclose(mean, point[0], atol=2e-3)
    assert (heatmap > 0).sum() <= 13 * 13
    assert (heatmap > 0).sum() >= 11 * 11


def test_heat_narrows_with_sigma_and_stays_on_the_map_outside_it():
    sharp, wide = heatmap_target(torch.tensor([0.5, 0.5]), 32, 0.5), heatmap_target(torch.tensor([0.5, 0.5]), 32, 3.0)
    assert sharp.max() > 5 * wide.max()
    outside = heatmap_target(torch.tensor([-3.0, 0.5]), 32, 1.0)
    assert outside.sum().item() == pytest.approx(1.0, abs=1e-5)
    assert outside[0].sum() > 0.4


def test_sigma_shrinks_then_stays():
    values = [shrinking_sigma(step, 3.0, 1.0, 100) for step in (0, 50, 100, 1000)]
    assert values == [3.0, 2.0, 1.0, 1.0]


def moved_far(before: torch.Tensor, after: torch.Tensor) -> torch.Tensor:
    """Largest share (...) over the angles of label probabilities (..., 3, bins) that moves by more than one bin."""
    near = before + before.roll(1, -1) + before.roll(-1, -1)
    return (after - near).clamp(min=0.0).sum(dim=-1).amax(dim=-1)


@pytest.mark.parametrize("tilt", [45.0, 44.99, 44.9, 44.0, 42.5, 40.0, -135.0])
def test_jitter_moves_no_label_far_even_where_the_angles_are_singular(tilt):
    # A hand that points down, tilted back: at exactly 45 degrees two of the angles mean nothing.
    rng = np.random.default_rng(0)
    hand = Rotation.from_euler("y", tilt, degrees=True) * Rotation.from_quat(geometry.top_down(0.0))
    hands = Rotation.from_euler("z", rng.uniform(-180, 180, (200, 1)), degrees=True) * hand
    jitter = Rotation.from_rotvec(np.deg2rad(0.01) * rng.normal(size=(200, 3)))
    before, after = (rotation_target(torch.from_numpy(turn.as_quat()), 72) for turn in (hands, jitter * hands))
    assert moved_far(before, after).max() < 0.05
    assert torch.allclose(before.sum(dim=-1), torch.ones(200, 3, dtype=before.dtype))


def test_labels_are_the_nearest_bins_half_a_bin_away_from_what_is_singular():
    quaternions = torch.from_numpy(Rotation.random(2000, random_state=2).as_quat())
    angles = quaternion_to_angles(quaternions)
    ordinary = angles[:, 1].abs() < math.radians(87.5)
    target = rotation_target(quaternions, 72)
    own = torch.nn.functional.one_hot(angle_bins(angles, 72), 72).to(target)
    assert ordinary.sum() > 1900 and torch.equal(target[ordinary], own[ordinary])
    # The likeliest bins are the same rotation everywhere.
    binned = angles_to_quaternion(bin_angles(target.argmax(dim=-1), 72).double())
    assert angle_between(quaternions.numpy(), binned.numpy()).max() < math.radians(7.6)
