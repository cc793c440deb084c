import pytest
import torch

from fakes import COLOURS
from fakes_action import observation
from lerobot_llakey import schema
from lerobot_llakey.policies.action.batch.point_cloud import fuse_views

WORKSPACE = torch.tensor(schema.WORKSPACE)


def test_points_lie_on_the_table_and_the_balls():
    batch, centres, _ = observation(rows=2)
    cloud = fuse_views(batch, schema.CAMERAS, WORKSPACE)
    assert cloud.points.shape == cloud.colours.shape == (len(cloud.rows), 3)
    for row in range(2):
        points = cloud.points[cloud.rows == row]
        on_table = points[:, 2].abs() < 2e-3
        on_ball = ((points[:, None] - centres[row]).norm(dim=-1) - 0.04).abs().amin(dim=1) < 2e-3
        assert (on_table | on_ball).all()
        assert on_ball.sum() > 10


def test_unmeasured_depth_makes_no_points():
    batch, _, _ = observation(rows=1)
    cloud = fuse_views(batch, schema.CAMERAS, WORKSPACE)
    depth = batch[schema.depth_key("front")]
    depth[:, :, :16] = 0.0
    depth[:, :, 16] = -1.0
    depth[:, :, 17, ::2] = float("nan")
    depth[:, :, 17, 1::2] = float("inf")
    fewer = fuse_views(batch, schema.CAMERAS, WORKSPACE)
    assert 0 < len(cloud.points) - len(fewer.points) <= 18 * 32
    assert fewer.points.isfinite().all()


def test_points_keep_the_colour_of_their_pixel():
    batch, centres, names = observation(rows=2)
    cloud = fuse_views(batch, schema.CAMERAS, WORKSPACE)
    for row in range(2):
        near = (cloud.rows == row) & ((cloud.points - centres[row, 0]).norm(dim=1) < 0.041)
        assert (cloud.colours[near] - torch.tensor(COLOURS[names[row]])).abs().max() < 0.01


def test_depth_in_whole_numbers_is_read_and_a_picture_of_it_refused():
    batch, _, _ = observation(rows=1)
    points = fuse_views(batch, schema.CAMERAS, WORKSPACE).points
    for camera in schema.CAMERAS:
        batch[schema.depth_key(camera)] = batch[schema.depth_key(camera)].to(torch.uint16)
        batch[schema.image_key(camera)] = (batch[schema.image_key(camera)] * 255).to(torch.uint8)
    assert torch.equal(fuse_views(batch, schema.CAMERAS, WORKSPACE).points, points)
    batch[schema.depth_key("wrist")] = batch[schema.depth_key("wrist")].to(torch.uint8)
    with pytest.raises(ValueError, match=r"wrist_depth in millimetres, .*got uint8"):
        fuse_views(batch, schema.CAMERAS, WORKSPACE)


def test_a_missing_camera_is_named():
    batch, _, _ = observation(rows=1)
    del batch[schema.depth_key("wrist")]
    with pytest.raises(ValueError, match=r"observation\.images\.wrist_depth"):
        fuse_views(batch, schema.CAMERAS, WORKSPACE)


def test_missing_calibration_is_named():
    batch, _, _ = observation(rows=1)
    del batch[schema.extrinsics_key("wrist")]
    with pytest.raises(ValueError, match=r"camera_extrinsics\.wrist"):
        fuse_views(batch, schema.CAMERAS, WORKSPACE)


def test_what_cannot_be_fused_is_refused():
    batch, _, _ = observation(rows=2)
    batch[schema.intrinsics_key("right_shoulder")][1] *= 4
    with pytest.raises(ValueError, match=r"camera_intrinsics\.right_shoulder .* of an image of 32x32"):
        fuse_views(batch, schema.CAMERAS, WORKSPACE)


def test_cameras_of_different_sizes_are_fused():
    batch, _, _ = observation(rows=2)
    whole, key = fuse_views(batch, schema.CAMERAS, WORKSPACE), "left_shoulder"
    others = fuse_views(batch, [camera for camera in schema.CAMERAS if camera != key], WORKSPACE)
    upper = dict(batch)  # the upper half of one camera: neither its size nor its shape is the others'
    for part in (schema.image_key(key), schema.depth_key(key)):
        upper[part] = batch[part][:, :, :24]
    upper[schema.intrinsics_key(key)] = batch[schema.intrinsics_key(key)] * torch.tensor([1, 1, 1, 1.0])
    fused = fuse_views(upper, schema.CAMERAS, WORKSPACE)
    assert len(others.rows) < len(fused.rows) < len(whole.rows)
    places = {tuple(point) for point in whole.points.tolist()}
    assert all(tuple(point) in places for point in fused.points.tolist())


def test_depth_of_another_size_than_the_image_is_refused():
    batch, _, _ = observation(rows=1)
    key = schema.depth_key("left_shoulder")
    batch[key] = batch[key][..., :16, :16]
    with pytest.raises(ValueError, match=r"left_shoulder_depth of shape \(1, 1, 32, 32\), got \(1, 1, 16, 16\)"):
        fuse_views(batch, schema.CAMERAS, WORKSPACE)


def test_a_cloud_without_points_in_the_workspace_names_its_row():
    batch, _, _ = observation(rows=2)
    for camera in schema.CAMERAS:
        batch[schema.depth_key(camera)][1] /= 1000.0  # metres by mistake
    with pytest.raises(ValueError, match=r"millimetres in .*front_depth.*batch row 1"):
        fuse_views(batch, schema.CAMERAS, torch.tensor([[0.0, 1.0], [-0.5, 0.5], [-0.05, 0.3]]))
