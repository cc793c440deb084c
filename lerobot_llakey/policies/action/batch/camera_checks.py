"""Whether cameras can be fused: calibration that fits the images, rigid extrinsics, depth in millimetres."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.checks.calibration import CENTRE
from lerobot_llakey.errors import LlakeyError

RIGID_TOLERANCE = 0.01
"""By how much an entry of R^T R may differ from the identity's; measured calibrations are rounded."""
NEAREST = 10.0
"""Millimetres that no depth camera measures; numbers below it are metres."""
NOT_MEASURED = 65535.0
"""What 16 bits hold at most: by it, as by 0, cameras say that nothing was measured."""
SKEW = 0.01
"""Share of the focal length that the skew may have, and the last row of the intrinsics may be off."""
ANGLES = (2.0, 170.0)
"""Degrees that a pinhole camera's field of view lies between."""


def check_calibration(intrinsics: Tensor, extrinsics: Tensor, cameras: Sequence[str], size: tuple[int, int]) -> None:
    """Check the calibration of the C cameras of a batch.

    Args:
        intrinsics: (B, C, 3, 3) in pixels.
        extrinsics: (B, C, 4, 4) camera-to-base, metres.
        cameras: the C names.
        size: height and width of the images in pixels.

    Raises:
        LlakeyError: naming the key, camera and batch row if the intrinsics are those of an image of another size, or
            the extrinsics are no rigid transform.
    """
    centres = intrinsics[..., :2, 2]
    shares = centres / centres.new_tensor((size[1], size[0]))
    focal = intrinsics.diagonal(dim1=-2, dim2=-1)[..., :2]
    wrong = ~((shares > CENTRE[0]) & (shares < CENTRE[1]) & (focal > 0) & focal.isfinite()).all(dim=-1)
    if wrong.any():
        row, camera = (int(index) for index in wrong.nonzero()[0])
        raise LlakeyError(
            f"Expected {schema.INTRINSICS} of an image of {size[1]}x{size[0]} pixels, got the principal point "
            f"({centres[row, camera, 0]:.1f}, {centres[row, camera, 1]:.1f}) and focal length "
            f"{intrinsics[row, camera, 0, 0]:.1f} for camera {cameras[camera]} in batch row {row}; rescale the "
            "intrinsics with the images."
        )
    _check_pinhole(intrinsics, cameras, size)
    rigid = _is_rigid(extrinsics)
    if not rigid.all():
        row, camera = (int(index) for index in (~rigid).nonzero()[0])
        raise LlakeyError(
            f"Expected a rigid camera-to-base transform (a rotation, metres, and the last row 0 0 0 1) in "
            f"{schema.EXTRINSICS}, got another matrix for camera {cameras[camera]} in batch row {row}; correct the "
            "calibration."
        )


def measured(depths: Tensor, cameras: Sequence[str]) -> Tensor:
    """Which depths (B, C, H, W) were measured: bool of the same shape.

    Zero and less, NaN, infinity and the largest number of 16 bits are how cameras say that nothing was.

    Raises:
        LlakeyError: naming the key and batch row if most of a camera's depths are nearer than any camera sees: they
            are metres.
    """
    seen = (depths > 0) & (depths < NOT_MEASURED)  # NaN is neither
    near = (seen & (depths < NEAREST)).flatten(2).sum(dim=2)
    metres = 2 * near > seen.flatten(2).sum(dim=2)
    if metres.any():
        row, camera = (int(index) for index in metres.nonzero()[0])
        value = depths[row, camera][seen[row, camera]].median().item()
        raise LlakeyError(
            f"Expected depth in millimetres in {schema.depth_key(cameras[camera])}, got most pixels below {NEAREST:g} "
            f"(such as {value:.3g}) in batch row {row}; convert metres to millimetres (--dataset.depth_output_unit=mm)."
        )
    return seen


def _check_pinhole(intrinsics: Tensor, cameras: Sequence[str], size: tuple[int, int]) -> None:
    """Refuse intrinsics that are no pinhole camera's: unprojection reads four of the nine numbers alone."""
    last = (intrinsics[..., 2, :] - intrinsics.new_tensor((0.0, 0.0, 1.0))).abs().amax(dim=-1)
    off = (intrinsics[..., 0, 1].abs() + intrinsics[..., 1, 0].abs()) / intrinsics[..., 0, 0]
    half = intrinsics.new_tensor((size[1] / 2, size[0] / 2))
    angles = 2 * (half / intrinsics.diagonal(dim1=-2, dim2=-1)[..., :2]).atan()
    low, high = (math.radians(angle) for angle in ANGLES)
    right = (last <= SKEW) & (off <= SKEW) & ((angles > low) & (angles < high)).all(dim=-1)
    if not right.all():
        row, camera = (int(index) for index in (~right).nonzero()[0])
        numbers = [[float(f"{number:.4g}") for number in line] for line in intrinsics[row, camera].tolist()]
        raise LlakeyError(
            f"Expected {schema.INTRINSICS} of a pinhole camera (no skew, the last row 0 0 1, a field of view between "
            f"{ANGLES[0]:g} and {ANGLES[1]:g} degrees), got {numbers} for camera {cameras[camera]} in batch row {row}; "
            "correct the calibration."
        )


def _is_rigid(matrices: Tensor) -> Tensor:
    """Which matrices (..., 4, 4) are a finite rotation and translation: (...) bool."""
    turn, last = matrices[..., :3, :3], matrices.new_tensor((0.0, 0.0, 0.0, 1.0))
    # Compared so that NaN is never rigid.
    square = (turn.transpose(-1, -2) @ turn - torch.eye(3, device=turn.device)).abs().amax(dim=(-2, -1))
    volume = torch.linalg.cross(turn[..., 0], turn[..., 1]).mul(turn[..., 2]).sum(dim=-1)
    bottom = (matrices[..., 3, :] - last).abs().amax(dim=-1)
    near = (square < RIGID_TOLERANCE) & (volume > 0) & (bottom < RIGID_TOLERANCE)
    return near & matrices[..., :3, 3].isfinite().all(dim=-1)
