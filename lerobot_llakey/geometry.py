"""Rigid poses, quaternions (xyzw) and pinhole cameras, in numpy for one pose and in torch for batches."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import torch
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation
from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError

DOWN = np.array([1.0, 0.0, 0.0, 0.0])
"""Quaternion (xyzw) of a hand that points straight down with its x axis along the base's x axis."""


@dataclass(frozen=True)
class Pose:
    """A rigid transform from a local frame to the base frame.

    Attributes:
        position: (3,) metres.
        quaternion: (4,) xyzw, kept at unit length with w >= 0.
    """

    position: np.ndarray
    quaternion: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 0.0, 1.0]))

    def __post_init__(self) -> None:
        # A copy: MuJoCo hands out views of arrays that it goes on to change.
        object.__setattr__(self, "position", np.array(self.position, dtype=np.float64).reshape(3))
        object.__setattr__(self, "quaternion", canonical_quaternion(self.quaternion))

    @staticmethod
    def of(numbers: ArrayLike) -> Pose:
        """Pose at the head of a state, a hand or an action: x y z in metres, then a quaternion xyzw."""
        numbers = np.asarray(numbers, dtype=np.float64)
        return Pose(numbers[schema.POSITION], numbers[schema.QUATERNION])

    @staticmethod
    def from_matrix(matrix: np.ndarray) -> Pose:
        """Pose of a (4, 4) homogeneous matrix."""
        return Pose(matrix[:3, 3], Rotation.from_matrix(matrix[:3, :3]).as_quat())

    @property
    def rotation(self) -> Rotation:
        return Rotation.from_quat(self.quaternion)

    @property
    def matrix(self) -> np.ndarray:
        """(4, 4) homogeneous matrix."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation.as_matrix()
        matrix[:3, 3] = self.position
        return matrix

    def __matmul__(self, other: Pose) -> Pose:
        """Composition: ``other`` is given in this pose's local frame."""
        return Pose(self.apply(other.position), (self.rotation * other.rotation).as_quat())

    def inverse(self) -> Pose:
        inverse = self.rotation.inv()
        return Pose(-inverse.apply(self.position), inverse.as_quat())

    def apply(self, points: ArrayLike) -> np.ndarray:
        """Local points (..., 3) in the base frame."""
        return self.rotation.apply(points) + self.position

    def shifted(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Pose:
        """The pose moved by (x, y, z) metres along the base's axes."""
        return Pose(self.position + np.array([x, y, z]), self.quaternion)

    def advanced(self, distance: float) -> Pose:
        """The pose moved by ``distance`` metres along its own z axis."""
        return Pose(self.position + distance * self.rotation.as_matrix()[:, 2], self.quaternion)

    def distance(self, other: Pose) -> tuple[float, float]:
        """Distance in metres and angle in radians to another pose."""
        angle = (self.rotation.inv() * other.rotation).magnitude()
        return float(np.linalg.norm(self.position - other.position)), float(angle)


def canonical_quaternion(quaternion: np.ndarray) -> np.ndarray:
    """The quaternion (4,) xyzw at unit length with w >= 0; raises as :func:`unit_quaternion` does."""
    quaternion = unit_quaternion(quaternion)
    return -quaternion if quaternion[3] < 0 else quaternion


def unit_quaternion(quaternion: np.ndarray) -> np.ndarray:
    """The quaternion (4,) xyzw at unit length, its sign kept.

    Raises:
        LlakeyError: if it is not four finite numbers of non-zero length.
    """
    quaternion = np.asarray(quaternion, dtype=np.float64)
    if quaternion.shape != (4,) or not np.isfinite(quaternion).all():
        raise LlakeyError(f"Expected a quaternion of 4 finite numbers (xyzw), got {quaternion}; check the pose.")
    largest = np.abs(quaternion).max()
    if largest > 1e100:  # its square would be infinite
        quaternion = quaternion / largest
    length = np.linalg.norm(quaternion)
    if length < 1e-6:
        raise LlakeyError(f"Expected a quaternion of non-zero length (xyzw), got {quaternion}; check the pose.")
    unit: np.ndarray = quaternion / length
    return unit


def nearest_sign(quaternion: np.ndarray, reference: np.ndarray = DOWN) -> np.ndarray:
    """Of a quaternion (4,) and its negation, which mean one rotation, the one nearer to a reference (4,)."""
    return -quaternion if quaternion @ reference < 0 else quaternion


def continuous_quaternions(quaternions: np.ndarray, reference: np.ndarray = DOWN) -> np.ndarray:
    """A trajectory of quaternions (T, 4) without jumps: each has the sign nearest to the one before.

    Args:
        quaternions: xyzw of either sign.
        reference: quaternion (4,) before the first one; by default a hand that points straight down, so that episodes
            agree.
    """
    before = np.concatenate((np.asarray(reference)[None], quaternions[:-1]))
    flips = np.where(np.sum(before * quaternions, axis=1) < 0, -1, 1).cumprod().astype(quaternions.dtype)
    return quaternions * flips[:, None]


def top_down(yaw: float = 0.0) -> np.ndarray:
    """Quaternion (xyzw) of a hand pointing straight down, turned by ``yaw`` radians about the base's z axis.

    At yaw 0 the fingers open along the base's y axis. A parallel gripper is the same after half a turn, so the yaw
    is brought into (-pi/2, pi/2].
    """
    yaw = np.pi / 2 - (np.pi / 2 - yaw) % np.pi
    return canonical_quaternion((Rotation.from_euler("z", yaw) * Rotation.from_quat(DOWN)).as_quat())


def rotation_error(first: Tensor, second: Tensor) -> Tensor:
    """Angle in degrees (B,) between hands with quaternions (B, 4) xyzw of either sign.

    A parallel gripper is the same after half a turn about its own z axis, so the smaller of both angles counts: in
    training, in keyframe accuracy and wherever else a rotation is judged.
    """
    first, second = (torch.nn.functional.normalize(each.double(), dim=-1) for each in (first, second))
    x, y, z, w = first.unbind(-1)
    half_turned = torch.stack((y, -x, w, -z), dim=-1)
    cosines = torch.stack([(each * second).sum(dim=-1).abs() for each in (first, half_turned)]).amax(dim=0)
    return torch.rad2deg(2 * cosines.clamp(max=1.0).arccos())


def quaternion_to_matrix(quaternion: Tensor) -> Tensor:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4) xyzw."""
    x, y, z, w = quaternion.unbind(-1)
    rows = (
        *(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        *(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        *(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    return torch.stack(rows, dim=-1).unflatten(-1, (3, 3))


def matrix_to_quaternion(matrix: Tensor) -> Tensor:
    """Unit quaternions (..., 4) xyzw with w >= 0 of rotation matrices (..., 3, 3)."""
    xx, yy, zz = matrix[..., 0, 0], matrix[..., 1, 1], matrix[..., 2, 2]
    yz = matrix[..., 2, 1] - matrix[..., 1, 2], matrix[..., 2, 1] + matrix[..., 1, 2]
    zx = matrix[..., 0, 2] - matrix[..., 2, 0], matrix[..., 0, 2] + matrix[..., 2, 0]
    xy = matrix[..., 1, 0] - matrix[..., 0, 1], matrix[..., 1, 0] + matrix[..., 0, 1]
    # Four ways to write the same quaternion, each scaled by one component: the largest is well conditioned.
    candidates = torch.stack(
        (
            torch.stack((1 + xx - yy - zz, xy[1], zx[1], yz[0]), dim=-1),
            torch.stack((xy[1], 1 - xx + yy - zz, yz[1], zx[0]), dim=-1),
            torch.stack((zx[1], yz[1], 1 - xx - yy + zz, xy[0]), dim=-1),
            torch.stack((yz[0], zx[0], xy[0], 1 + xx + yy + zz), dim=-1),
        ),
        dim=-2,
    )
    best = candidates.diagonal(dim1=-2, dim2=-1).argmax(dim=-1)
    quaternion = candidates.gather(-2, best[..., None, None].expand(*best.shape, 1, 4)).squeeze(-2)
    quaternion = torch.nn.functional.normalize(quaternion, dim=-1)
    return torch.where(quaternion[..., 3:] < 0, -quaternion, quaternion)


def pose_to_matrix[Array: (np.ndarray, Tensor)](pose: Array) -> Array:
    """Homogeneous matrices (..., 4, 4) of poses (..., 7): position, then a quaternion xyzw of either sign."""
    if not isinstance(pose, Tensor):
        return pose_to_matrix(torch.as_tensor(pose)).numpy()
    matrix = torch.zeros(*pose.shape[:-1], 4, 4, dtype=pose.dtype, device=pose.device)
    matrix[..., :3, :3] = quaternion_to_matrix(torch.nn.functional.normalize(pose[..., 3:], dim=-1))
    matrix[..., :3, 3] = pose[..., :3]
    matrix[..., 3, 3] = 1.0
    return matrix


def matrix_to_pose[Array: (np.ndarray, Tensor)](matrix: Array) -> Array:
    """Poses (..., 7), position and quaternion xyzw with w >= 0, of homogeneous matrices (..., 4, 4)."""
    if not isinstance(matrix, Tensor):
        return matrix_to_pose(torch.as_tensor(matrix)).numpy()
    return torch.cat((matrix[..., :3, 3], matrix_to_quaternion(matrix[..., :3, :3])), dim=-1)


def intrinsics_to_matrix(intrinsics: Tensor) -> Tensor:
    """Matrices (..., 3, 3) of intrinsics (..., 4): fx, fy, cx and cy in pixels."""
    focal_x, focal_y, centre_x, centre_y = intrinsics.unbind(-1)
    zero, one = torch.zeros_like(focal_x), torch.ones_like(focal_x)
    rows = (focal_x, zero, centre_x, zero, focal_y, centre_y, zero, zero, one)
    return torch.stack(rows, dim=-1).unflatten(-1, (3, 3))


def pinhole_intrinsics(fovy_degrees: float, height: int, width: int) -> np.ndarray:
    """Intrinsics (4,) fx, fy, cx, cy in pixels of a pinhole camera with square pixels and a vertical field of view."""
    focal = 0.5 * height / np.tan(np.deg2rad(fovy_degrees) / 2)
    return np.array([focal, focal, width / 2, height / 2])


def unproject(depth: Tensor, intrinsics: Tensor, extrinsics: Tensor) -> Tensor:
    """Lift depth maps into the base frame.

    Args:
        depth: (..., H, W) z-depth in metres.
        intrinsics: (..., 3, 3) in pixels.
        extrinsics: (..., 4, 4) camera-to-base.

    Returns:
        (..., H, W, 3) points in metres; pixel centres lie at half-integer coordinates.
    """
    height, width = depth.shape[-2:]
    v = torch.arange(height, device=depth.device, dtype=depth.dtype)[:, None] + 0.5
    u = torch.arange(width, device=depth.device, dtype=depth.dtype)[None, :] + 0.5
    focal_x, focal_y = intrinsics[..., 0, 0, None, None], intrinsics[..., 1, 1, None, None]
    centre_x, centre_y = intrinsics[..., 0, 2, None, None], intrinsics[..., 1, 2, None, None]
    local = torch.stack(((u - centre_x) / focal_x * depth, (v - centre_y) / focal_y * depth, depth), dim=-1)
    rotation, translation = extrinsics[..., :3, :3], extrinsics[..., :3, 3]
    return torch.einsum("...ij,...hwj->...hwi", rotation, local) + translation[..., None, None, :]
