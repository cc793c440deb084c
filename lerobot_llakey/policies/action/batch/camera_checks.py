"""Whether cameras can be fused: calibration that fits the images, poses in metres, depth in millimetres."""

from __future__ import annotations

import math
from collections.abc import Sequence

from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.checks.calibration import CENTRE
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.schema import FARTHEST, UNIT_TOLERANCE

NEAREST = 10.0
"""Millimetres that no depth camera measures; numbers below it are metres."""
NOT_MEASURED = 65535.0
"""What 16 bits hold at most: by it, as by 0, cameras say that nothing was measured."""
ANGLES = (2.0, 170.0)
"""Degrees that a pinhole camera's field of view lies between."""


def check_calibration(intrinsics: Tensor, poses: Tensor, cameras: Sequence[str], size: tuple[int, int]) -> None:
    """Check the calibration of C cameras of a batch.

    Args:
        intrinsics: (B, C, 4) fx, fy, cx and cy in pixels.
        poses: (B, C, 7) camera-to-base, metres and quaternion xyzw.
        cameras: the C names.
        size: height and width of the images in pixels.

    Raises:
        LlakeyError: naming the key and batch row if the intrinsics are those of an image of another size, or no pinhole
            camera's, or the pose is not finite or its quaternion not of unit length.
    """
    width_height = intrinsics.new_tensor((size[1], size[0]))
    focal, centre = intrinsics[..., :2], intrinsics[..., 2:]
    angles = 2 * (width_height / (2 * focal)).atan()
    low, high = (math.radians(angle) for angle in ANGLES)
    shares = centre / width_height
    # Compared so that NaN is never right.
    right = ((shares > CENTRE[0]) & (shares < CENTRE[1]) & (angles > low) & (angles < high)).all(dim=-1)
    if not right.all():
        row, camera = (int(index) for index in (~right).nonzero()[0])
        raise LlakeyError(
            f"Expected {schema.intrinsics_key(cameras[camera])} (fx, fy, cx, cy) of an image of {size[1]}x{size[0]} "
            f"pixels with a field of view between {ANGLES[0]:g} and {ANGLES[1]:g} degrees, got "
            f"{_numbers(intrinsics[row, camera])} in batch row {row}; rescale the intrinsics with the images."
        )
    length = poses[..., schema.QUATERNION].norm(dim=-1)
    right = (poses[..., schema.POSITION].abs() <= FARTHEST).all(dim=-1) & ((length - 1).abs() <= UNIT_TOLERANCE)
    if not right.all():
        row, camera = (int(index) for index in (~right).nonzero()[0])
        raise LlakeyError(
            f"Expected {schema.extrinsics_key(cameras[camera])} as a position within {FARTHEST:g} m of the base and a "
            f"unit quaternion xyzw, got {_numbers(poses[row, camera])} in batch row {row}; correct the calibration."
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


def _numbers(values: Tensor) -> list[float]:
    return [float(f"{number:.4g}") for number in values.tolist()]
