import pytest
import torch

from fakes import fake_cameras
from lerobot_llakey import schema
from lerobot_llakey.policies.action.batch.camera_checks import check_calibration, measured
from lerobot_llakey.policies.action.batch.point_cloud import read_calibration

CAMERAS = ("front", "left", "right", "wrist")


def calibration(rows=2):
    return tuple(torch.from_numpy(numbers).repeat(rows, 1, 1) for numbers in fake_cameras(32))


def test_good_calibration_passes_however_it_is_rounded_and_signed():
    intrinsics, poses = calibration()
    check_calibration(intrinsics, poses, CAMERAS, (32, 32))
    check_calibration(intrinsics, (poses * 1000).round() / 1000, CAMERAS, (32, 32))
    check_calibration(intrinsics, torch.cat((poses[..., :3], -poses[..., 3:]), dim=-1), CAMERAS, (32, 32))


@pytest.mark.parametrize("factor", [0.25, 0.5, 2.0, 4.0, float("nan")])
def test_intrinsics_of_another_image_size_are_refused(factor):
    intrinsics, poses = calibration()
    intrinsics[1, 2] *= factor
    with pytest.raises(ValueError, match=r"camera_intrinsics\.right .*32x32 pixels.*in batch row 1"):
        check_calibration(intrinsics, poses, CAMERAS, (32, 32))


@pytest.mark.parametrize("focal", [0.0, -30.0, float("inf"), 1.0, 3000.0])
def test_impossible_focal_lengths_are_refused(focal):
    intrinsics, poses = calibration()
    intrinsics[0, 1, 1] = focal
    with pytest.raises(ValueError, match=r"camera_intrinsics\.left .*between 2 and 170 degrees.*in batch row 0"):
        check_calibration(intrinsics, poses, CAMERAS, (32, 32))


@pytest.mark.parametrize(
    ("place", "value"), [(0, float("nan")), (1, 700.0), (3, float("nan")), (6, 3.0), (slice(3, 7), 0.0)]
)
def test_a_pose_that_is_none_is_refused(place, value):
    intrinsics, poses = calibration()
    poses[1, 3, place] = value
    with pytest.raises(ValueError, match=r"camera_extrinsics\.wrist as a position .*unit quaternion.*in batch row 1"):
        check_calibration(intrinsics, poses, CAMERAS, (32, 32))


def test_calibration_of_another_shape_is_refused():
    batch = {schema.intrinsics_key("front"): torch.zeros(2, 4), schema.extrinsics_key("front"): torch.zeros(2, 4, 4)}
    with pytest.raises(ValueError, match=r"camera_extrinsics\.front of shape \(2, 7\)"):
        read_calibration(batch, ["front"])


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf"), 0.0, -3.0, 65535.0])
def test_what_cameras_give_where_they_measured_nothing_is_not_measured(value):
    depths = torch.full((3, 4, 8, 8), 700.0)
    depths[2, 1, 5, 6] = value
    seen = measured(depths, CAMERAS)
    assert not seen[2, 1, 5, 6] and seen.sum() == depths.numel() - 1


def test_depth_in_metres_is_refused_even_of_one_camera_and_with_a_far_pixel():
    depths = torch.full((3, 4, 8, 8), 700.0)
    depths[2, 1], depths[1, 0] = 0.7, 0.0  # a camera that measured nothing is no reason
    depths[2, 1, 0, 0] = 41.0
    with pytest.raises(ValueError, match=r"millimetres in .*images\.left_depth, .*such as 0\.7\) in batch row 2"):
        measured(depths, CAMERAS)
