"""Poses, quaternions and cameras agree with scipy and with each other."""

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import (
    DOWN,
    Pose,
    canonical_quaternion,
    continuous_quaternions,
    intrinsics_to_matrix,
    matrix_to_pose,
    matrix_to_quaternion,
    nearest_sign,
    pinhole_intrinsics,
    pose_to_matrix,
    quaternion_to_matrix,
    rotation_error,
    top_down,
    unit_quaternion,
    unproject,
)

quaternions = st.integers(0, 2**32 - 1).map(lambda seed: Rotation.random(random_state=seed).as_quat())


@given(quaternions)
def test_quaternion_and_matrix_are_inverse(quaternion: np.ndarray) -> None:
    matrix = quaternion_to_matrix(torch.tensor(quaternion))
    assert np.allclose(matrix.numpy(), Rotation.from_quat(quaternion).as_matrix(), atol=1e-6)
    assert np.allclose(matrix_to_quaternion(matrix).numpy(), canonical_quaternion(quaternion), atol=1e-6)


@given(quaternions, quaternions)
def test_pose_composition_is_matrix_product(first: np.ndarray, second: np.ndarray) -> None:
    a, b = Pose(np.array([0.1, -0.2, 0.3]), first), Pose(np.array([-1.0, 0.5, 0.2]), second)
    assert np.allclose((a @ b).matrix, a.matrix @ b.matrix)
    assert np.allclose((a @ a.inverse()).matrix, np.eye(4))
    assert np.allclose(Pose.from_matrix(a.matrix).matrix, a.matrix)


@pytest.mark.parametrize("yaw", [-3.0, -1.6, 0.0, 0.4, 1.5, 2.9])
def test_top_down_points_down_and_is_the_same_after_half_a_turn(yaw: float) -> None:
    matrix = Rotation.from_quat(top_down(yaw)).as_matrix()
    assert np.allclose(matrix[:, 2], (0, 0, -1))
    assert np.allclose(top_down(yaw), top_down(yaw + np.pi))
    assert abs(matrix[:, 1] @ (np.sin(yaw), -np.cos(yaw), 0)) == pytest.approx(1)


def test_advancing_moves_along_the_tool() -> None:
    assert np.allclose(Pose(np.zeros(3), top_down(0.7)).advanced(0.2).position, (0, 0, -0.2))


@pytest.mark.parametrize("bad", [np.zeros(4), np.array([0, 0, np.nan, 1]), np.ones(3)])
def test_bad_quaternions_are_refused(bad: np.ndarray) -> None:
    with pytest.raises(ValueError, match="Expected a quaternion"):
        canonical_quaternion(bad)


def test_unproject_inverts_projection() -> None:
    height, width = 6, 8
    intrinsics = intrinsics_to_matrix(torch.tensor(pinhole_intrinsics(60, height, width)))
    extrinsics = Pose(np.array([0.3, 0.1, 1.0]), top_down(0.3)).matrix
    depth = torch.rand(height, width, dtype=torch.float64) + 0.5
    points = unproject(depth, intrinsics, torch.tensor(extrinsics)).numpy()
    local = (points - extrinsics[:3, 3]) @ extrinsics[:3, :3]
    pixels = local @ intrinsics.numpy().T
    pixels = pixels[..., :2] / pixels[..., 2:]
    v, u = np.mgrid[:height, :width]
    assert np.allclose(pixels, np.stack((u, v), axis=-1) + 0.5)
    assert np.allclose(local[..., 2], depth.numpy())


@pytest.mark.parametrize("length", [1e-5, 1e120, 1e155, 1.7e308])
def test_quaternions_of_any_length_are_brought_to_one(length: float) -> None:
    assert np.allclose(canonical_quaternion(np.array((0.6, 0.0, 0.0, -0.8)) * length), (-0.6, 0.0, 0.0, 0.8))


def test_a_quaternion_without_length_is_named() -> None:
    with pytest.raises(ValueError, match=r"1\.e-20"):
        canonical_quaternion(np.array((0.0, 0.0, 1e-20, 0.0)))


@given(quaternions)
def test_poses_and_matrices_are_inverse_in_numpy_and_torch_alike(quaternion: np.ndarray) -> None:
    poses = np.stack([np.append((0.1, -0.2, 0.3), sign * 2.0 * quaternion) for sign in (1, -1)])
    matrices = pose_to_matrix(poses)
    assert np.allclose(matrices, Pose(poses[0, :3], quaternion).matrix)
    assert np.allclose(pose_to_matrix(torch.tensor(poses)).numpy(), matrices)
    expected = np.append((0.1, -0.2, 0.3), canonical_quaternion(quaternion))
    assert np.allclose(matrix_to_pose(matrices), expected, atol=1e-6)
    assert np.allclose(matrix_to_pose(torch.tensor(matrices)).numpy(), expected, atol=1e-6)


def test_intrinsics_become_a_matrix() -> None:
    matrix = intrinsics_to_matrix(torch.tensor([[1.0, 2.0, 3.0, 4.0]]))
    assert matrix.tolist() == [[[1, 0, 3], [0, 2, 4], [0, 0, 1]]]


def test_a_trajectory_has_no_jumps_and_begins_nearest_to_the_reference() -> None:
    angles = np.linspace(0, 4 * np.pi, 50)
    smooth = Rotation.from_rotvec(np.outer(angles, (0.0, 1.0, 0.0))) * Rotation.from_quat(DOWN)
    jumping = np.stack([canonical_quaternion(quaternion) for quaternion in smooth.as_quat()])
    jumping[::3] *= -1
    for reference in (DOWN, -DOWN):
        path = continuous_quaternions(jumping, reference)
        assert path[0] @ reference > 0.99
        assert (np.sum(path[1:] * path[:-1], axis=1) > 0).all()
        assert np.allclose(np.abs(np.sum(path * jumping, axis=1)), 1)
    assert continuous_quaternions(jumping.astype(np.float32)).dtype == np.float32


def test_a_single_quaternion_takes_the_nearer_sign() -> None:
    quaternion = np.array((-0.8, 0.0, 0.0, 0.6))
    assert np.array_equal(nearest_sign(quaternion), -quaternion)
    assert np.array_equal(nearest_sign(quaternion, quaternion), quaternion)
    assert np.allclose(unit_quaternion(5 * quaternion), quaternion)


def test_rotation_error_forgives_half_a_turn_of_the_gripper_only() -> None:
    hand = Rotation.from_quat(top_down(0.2))
    tilted = Rotation.from_euler("x", 8, degrees=True) * hand
    others = [
        hand * Rotation.from_euler("z", 180, degrees=True),
        tilted,
        tilted * Rotation.from_euler("z", 180, degrees=True),
        hand * Rotation.from_euler("x", 180, degrees=True),
    ]
    first = torch.from_numpy(hand.as_quat()).float().expand(4, 4)
    second = torch.from_numpy(np.stack([other.as_quat() for other in others])).float()
    for signed in (second, -second):
        assert torch.allclose(rotation_error(first, signed).float(), torch.tensor([0.0, 8, 8, 180]), atol=0.1)


def test_the_pose_at_the_head_of_a_state_is_so_far_from_that_of_an_action() -> None:
    state = np.array([0, 0, 0, 0, 0, 0, 1, *[0.5] * 8], dtype=np.float32)
    action = np.array([0.03, 0, 0.04, 0, 0, -np.sin(np.pi / 8), -np.cos(np.pi / 8), 1, 0], dtype=np.float32)
    assert Pose.of(state).distance(Pose.of(action)) == pytest.approx((0.05, np.pi / 4), abs=1e-6)
