import pytest
import torch

from fakes import fake_cameras
from lerobot_llakey import schema
from lerobot_llakey.policies.action.batch.camera_checks import check_calibration, measured
from lerobot_llakey.policies.action.batch.point_cloud import read_calibration

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
    with pytest.raises(ValueError, match=r"camera_extrinsics of shape \(\d, 4, 4, 4\)"):
        read_calibration({schema.INTRINSICS: intrinsics, schema.EXTRINSICS: extrinsics[:, :3]}, CAMERAS)


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


@pytest.mark.parametrize(
    ("place", "value"),
    [((2, 2), 0.5), ((2, 0), 0.3), ((0, 1), 5.0), ((0, 0), 1e9), ((1, 1), 0.1), ((2, 2), float("nan"))],
)
def test_intrinsics_of_no_pinhole_camera_are_refused(place, value):
    intrinsics, extrinsics = calibration()
    intrinsics[1, 2][place] = value
    with pytest.raises(ValueError, match=r"camera_intrinsics.* camera right in batch row 1"):
        check_calibration(intrinsics, extrinsics, CAMERAS, (32, 32))
