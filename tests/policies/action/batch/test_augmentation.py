import math

import pytest
import torch

from lerobot_llakey import geometry, schema
from lerobot_llakey.policies.action.batch.augmentation import blurred, jittered, sample_motion
from lerobot_llakey.policies.action.batch.point_cloud import PointCloud, inside

WORKSPACE = torch.tensor(schema.WORKSPACE)


def random_poses(count):
    generator = torch.Generator().manual_seed(0)
    low, high = WORKSPACE[:, 0], WORKSPACE[:, 1]
    positions = low + torch.rand(count, 3, generator=generator) * (high - low)
    return positions, torch.nn.functional.normalize(torch.randn(count, 4, generator=generator), dim=-1)


def test_targets_stay_in_the_workspace_and_move_within_the_limits():
    positions, _ = random_poses(2000)
    motion = sample_motion(positions, WORKSPACE, 0.125, 45.0)
    moved = motion.move_points(positions)
    assert ((moved > WORKSPACE[:, 0]) & (moved < WORKSPACE[:, 1])).all()
    assert (moved - positions).abs().max() <= 0.125 + 1e-5
    assert (moved - positions).abs().amax(dim=0).min() > 0.1
    assert 40 < math.degrees(motion.yaw.abs().max()) <= 45


def test_a_blurred_turn_is_off_by_as_much_as_said_about_every_axis():
    _, quaternions = random_poses(4000)
    torch.manual_seed(0)
    told = geometry.quaternion_to_matrix(blurred(quaternions, 5.0))
    error = geometry.quaternion_to_matrix(quaternions).transpose(1, 2) @ told
    about = torch.stack((error[:, 2, 1], error[:, 0, 2], error[:, 1, 0]), dim=1)
    assert torch.rad2deg(about.std(dim=0)) == pytest.approx([5.0] * 3, rel=0.1)
    assert torch.rad2deg(about.mean(dim=0)).abs().max() < 0.5


def test_points_and_poses_move_as_one_body():
    positions, quaternions = random_poses(50)
    motion = sample_motion(positions, WORKSPACE, 0.125, 45.0)
    rotation = geometry.quaternion_to_matrix(quaternions)
    tips = positions + 0.1 * rotation[..., 2]
    moved, moved_tips = motion.move_points(positions), motion.move_points(tips)
    turned = geometry.quaternion_to_matrix(motion.move_quaternion(quaternions))
    assert torch.allclose(moved_tips, moved + 0.1 * turned[..., 2], atol=1e-5)
    assert torch.allclose(moved, positions + motion.translation, atol=1e-5)


def test_no_limits_leave_the_scene_alone():
    positions, quaternions = random_poses(10)
    inner = positions.clamp(min=WORKSPACE[:, 0] + 0.02, max=WORKSPACE[:, 1] - 0.02)
    motion = sample_motion(inner, WORKSPACE, 0.0, 0.0)
    assert torch.allclose(motion.move_points(inner), inner, atol=1e-6)
    turned = geometry.quaternion_to_matrix(motion.move_quaternion(quaternions))
    assert torch.allclose(turned, geometry.quaternion_to_matrix(quaternions), atol=1e-5)


def test_moved_cameras_see_the_moved_scene():
    positions, quaternions = random_poses(3)
    motion = sample_motion(positions, WORKSPACE, 0.125, 45.0)
    poses = torch.cat((torch.randn(3, 3, generator=torch.Generator().manual_seed(1)), quaternions), dim=1)
    seen = torch.linalg.solve(geometry.pose_to_matrix(poses)[:, :3, :3], (positions - poses[:, :3])[..., None])
    after = geometry.pose_to_matrix(motion.move_poses(poses))
    again = (after[:, :3, :3] @ seen).squeeze(-1) + after[:, :3, 3]
    assert torch.allclose(again, motion.move_points(positions), atol=1e-5)


def test_targets_at_the_very_edge_stay_inside():
    highest = torch.nextafter(WORKSPACE[:, 1], torch.full((3,), -9.0))
    corners = torch.cartesian_prod(*torch.stack((WORKSPACE[:, 0], highest), dim=1)).repeat(200, 1)
    for translation in (0.0, 0.125):
        motion = sample_motion(corners, WORKSPACE, translation, 45.0)
        assert inside(motion.move_points(corners), WORKSPACE).all()


def a_cloud(*counts):
    rows = torch.repeat_interleave(torch.arange(len(counts)), torch.tensor(counts))
    return PointCloud(torch.rand(len(rows), 3), torch.full((len(rows), 3), 0.5), rows)


def test_colours_change_by_row_and_within_the_limits():
    cloud = a_cloud(*[2] * 500)
    colours = jittered(cloud, 500, 0.2).colours
    assert torch.equal(colours[::2], colours[1::2]), "one change for all points of a row"
    assert (colours - 0.5).abs().max() <= 0.1 + 1e-6
    assert colours.std(dim=0).min() > 0.03
    cloud.colours[:] = 1.0
    assert jittered(cloud, 500, 0.2).colours.max() <= 1.0


def test_nothing_is_varied_by_default():
    cloud = a_cloud(10, 10)
    state = torch.get_rng_state()
    same = jittered(cloud, 2, 0.0)
    assert torch.equal(same.points, cloud.points) and torch.equal(same.colours, cloud.colours)
    assert torch.equal(torch.get_rng_state(), state)
