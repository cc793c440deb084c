import pytest
import torch

from fakes import fake_cameras
from lerobot_llakey.policies.action.batch.camera_checks import check_calibration, check_depth

CAMERAS = ("front", "left", "right", "wrist")


def calibration(rows=2):
    return tuple(torch.from_numpy(matrices).repeat(rows, 1, 1, 1) for matrices in fake_cameras(32))


def test_good_calibration_passes_however_it_is_rounded():
    intrinsics, extrinsics = calibration()
    check_calibration(intrinsics, extrinsics, CAMERAS, (32, 32))
    check_calibration(intrinsics, (extrinsics * 1000).round() / 1000, CAMERAS, (32, 32))


@pytest.mark.parametrize("factor", [0.25, 0.5, 2.0, 4.0, float("nan")])
def test_intrinsics_of_another_image_size_are_refused(factor):
    intrinsics, extrinsics = calibration()
    intrinsics[1, 2, :2] *= factor
    with pytest.raises(ValueError, match=r"32x32 pixels.*right in batch row 1"):
        check_calibration(intrinsics, extrinsics, CAMERAS, (32, 32))


@pytest.mark.parametrize("focal", [0.0, -30.0, float("inf")])
def test_impossible_focal_lengths_are_refused(focal):
    intrinsics, extrinsics = calibration()
    intrinsics[0, 1, 1, 1] = focal
    with pytest.raises(ValueError, match=r"camera_intrinsics.*left in batch row 0"):
        check_calibration(intrinsics, extrinsics, CAMERAS, (32, 32))


def spoil(matrix, how):
    if how == "scaled":
        matrix[:3, :3] *= 1.05
    elif how == "mirrored":
        matrix[:3, 0] *= -1
    elif how == "transposed":
        matrix[:] = matrix.T.clone()
    elif how == "nowhere":
        matrix[0, 3] = float("nan")
    elif how == "not a number":
        matrix[1, 1] = float("nan")
    else:
        matrix.zero_()


@pytest.mark.parametrize("how", ["scaled", "mirrored", "transposed", "nowhere", "not a number", "zero"])
def test_extrinsics_that_are_no_rigid_transform_are_refused(how):
    intrinsics, extrinsics = calibration()
    spoil(extrinsics[1, 3], how)
    with pytest.raises(ValueError, match=r"rigid.*camera_extrinsics.*wrist in batch row 1"):
        check_calibration(intrinsics, extrinsics, CAMERAS, (32, 32))


def test_fewer_matrices_than_cameras_are_refused():
    intrinsics, extrinsics = calibration()
    with pytest.raises(ValueError, match=r"camera_extrinsics of shape \(batch, 4, 4, 4\)"):
        check_calibration(intrinsics, extrinsics[:, :3], CAMERAS, (32, 32))


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_depth_that_is_not_finite_is_refused(value):
    depths = torch.full((3, 4, 8, 8), 700.0)
    depths[0, 0, 0] = 0.0
    check_depth(depths, CAMERAS)
    depths[2, 1, 5, 6] = value
    with pytest.raises(ValueError, match=r"images\.left_depth.*batch row 2"):
        check_depth(depths, CAMERAS)
