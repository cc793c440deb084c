"""Fuse calibrated RGB-D views into one coloured point cloud in the base frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from lerobot_llakey import geometry, schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.batch.camera_checks import check_calibration, measured
from lerobot_llakey.policies.batch import read_images, read_numbers

MILLIMETRES = 1e-3


@dataclass
class PointCloud:
    """The coloured clouds of a batch, end to end: every later step then costs only what was measured.

    Attributes:
        points: (M, 3) in metres, base frame.
        colours: (M, 3) in 0..1.
        rows: (M,) int64 batch row that each point belongs to.
    """

    points: Tensor
    colours: Tensor
    rows: Tensor


def inside(points: Tensor, workspace: Tensor) -> Tensor:
    """Which points (..., 3) lie inside bounds (3, 2) in metres; NaN never does."""
    mask = torch.ones_like(points[..., 0], dtype=torch.bool)
    for axis, (low, high) in enumerate(workspace.tolist()):
        mask &= (points[..., axis] >= low) & (points[..., axis] < high)
    return mask


def _camera_stack(batch: Mapping[str, Any], cameras: Sequence[str]) -> tuple[Tensor, Tensor]:
    keys = [schema.image_key(camera) for camera in cameras]
    images = read_images(batch, keys)
    depths = []
    for camera in cameras:
        key = schema.depth_key(camera)
        if key not in batch:
            given = ", ".join(sorted(name for name in batch if name.startswith(schema.image_key(""))))
            raise LlakeyError(f"Expected the depth {key} in the batch, got {given}; add it.")
        depth = read_numbers(batch, key, (1, "height", "width"), len(images[0]))
        if depth.dtype in (torch.uint8, torch.int8, torch.bool):
            raise LlakeyError(
                f"Expected {key} in millimetres, as floats or whole numbers of 16 bits or more, got "
                f"{str(depth.dtype).removeprefix('torch.')}; record depth, not a picture of it."
            )
        depths.append(depth.float())
    size = images[0].shape[-2:]
    for value, key in zip((*images, *depths), (*keys, *(schema.depth_key(camera) for camera in cameras)), strict=True):
        if value.shape[-2:] != size:
            raise LlakeyError(
                f"Expected every camera at {tuple(size)} pixels, got {key} at {tuple(value.shape[-2:])}; record all "
                "cameras at one size."
            )
    return torch.stack([image.float() for image in images], dim=1), torch.stack(depths, dim=1).squeeze(2)


def read_calibration(
    batch: Mapping[str, Any], cameras: Sequence[str], rows: int | None = None
) -> tuple[Tensor, Tensor]:
    """Intrinsics (B, C, 3, 3) in pixels and camera-to-base extrinsics (B, C, 4, 4) in metres.

    Raises:
        LlakeyError: naming the key if one is missing, holds no numbers, or not one matrix for each camera.
    """
    intrinsics = read_numbers(batch, schema.INTRINSICS, (len(cameras), 3, 3), rows)
    extrinsics = read_numbers(batch, schema.EXTRINSICS, (len(cameras), 4, 4), len(intrinsics))
    return intrinsics.float(), extrinsics.float()


def fuse_views(batch: Mapping[str, Any], cameras: Sequence[str], workspace: Tensor) -> PointCloud:
    """One cloud for each row of a batch in the data contract.

    Args:
        batch: RGB (B, 3, H, W) in 0..1 or uint8 and depth (B, 1, H, W) in millimetres for each camera; intrinsics
            (B, C, 3, 3) in pixels and camera-to-base extrinsics (B, C, 4, 4).
        cameras: names of the C cameras in the order of the calibration.
        workspace: (3, 2) bounds in metres.

    Returns:
        The points inside the workspace, where depth was measured, see :func:`camera_checks.measured`.

    Raises:
        LlakeyError: naming the key and batch row if a camera or its calibration is missing, an image's size does not
            fit its intrinsics, extrinsics are no rigid transform, colours or depths are in another unit, or a row has
            no point inside the workspace.
    """
    images, depths = _camera_stack(batch, cameras)
    intrinsics, extrinsics = read_calibration(batch, cameras, len(images))
    check_calibration(intrinsics, extrinsics, cameras, (images.shape[-2], images.shape[-1]))
    seen = measured(depths, cameras)
    depths = torch.where(seen, depths, 0.0)
    points = geometry.unproject(depths * MILLIMETRES, intrinsics, extrinsics).flatten(1, 3)  # (B, C*H*W, 3)
    valid = inside(points, workspace) & seen.flatten(1)
    empty = ~valid.any(dim=1)
    if empty.any():
        row = int(empty.nonzero()[0])
        raise LlakeyError(
            f"Expected points inside the workspace {workspace.tolist()} (metres), got a cloud with none from "
            f"{schema.depth_key(cameras[0])} and the other cameras in batch row {row}; check the depth's unit "
            f"(millimetres), {schema.EXTRINSICS} and the workspace."
        )
    rows, place = valid.nonzero(as_tuple=True)
    colours = images.permute(0, 1, 3, 4, 2).flatten(1, 3)
    return PointCloud(points[rows, place], colours[rows, place], rows)
