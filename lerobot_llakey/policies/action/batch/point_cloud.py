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
    """The coloured clouds of a batch, in one: every later step then costs only what was measured.

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


@dataclass(frozen=True)
class _Views:
    """C cameras of one image size, as read from a batch of B rows.

    Attributes:
        cameras: the names.
        colours: (B, C, 3, H, W) in 0..1.
        depths: (B, C, H, W) in millimetres.
        intrinsics: (B, C, 4) in pixels.
        poses: (B, C, 7) camera-to-base.
    """

    cameras: tuple[str, ...]
    colours: Tensor
    depths: Tensor
    intrinsics: Tensor
    poses: Tensor


def _read_depth(batch: Mapping[str, Any], camera: str, like: Tensor) -> Tensor:
    """A camera's depth (B, H, W), one number for each pixel of its image (B, 3, H, W)."""
    key = schema.depth_key(camera)
    if key not in batch:
        given = ", ".join(sorted(name for name in batch if name.startswith(schema.image_key(""))))
        raise LlakeyError(f"Expected the depth {key} in the batch, got {given}; add it.")
    depth = read_numbers(batch, key, (1, *like.shape[-2:]), len(like))
    if depth.dtype in (torch.uint8, torch.int8, torch.bool):
        raise LlakeyError(
            f"Expected {key} in millimetres, as floats or whole numbers of 16 bits or more, got "
            f"{str(depth.dtype).removeprefix('torch.')}; record depth, not a picture of it."
        )
    return depth.float().squeeze(1)


def _read_views(batch: Mapping[str, Any], cameras: Sequence[str]) -> list[_Views]:
    """The cameras, those of one image size together: they are unprojected at once."""
    images = read_images(batch, [schema.image_key(camera) for camera in cameras])
    rows, sizes = len(images[0]), [tuple(image.shape[-2:]) for image in images]
    views = []
    for size in dict.fromkeys(sizes):
        alike = [place for place, other in enumerate(sizes) if other == size]
        names = tuple(cameras[place] for place in alike)
        views.append(
            _Views(
                names,
                torch.stack([images[place].float() for place in alike], dim=1),
                torch.stack([_read_depth(batch, cameras[place], images[place]) for place in alike], dim=1),
                *read_calibration(batch, names, rows),
            )
        )
    return views


def read_calibration(
    batch: Mapping[str, Any], cameras: Sequence[str], rows: int | None = None
) -> tuple[Tensor, Tensor]:
    """Intrinsics (B, C, 4) in pixels and camera-to-base poses (B, C, 7) of C cameras.

    Raises:
        LlakeyError: naming the key if one is missing, holds no numbers, or is of another shape.
    """
    intrinsics = [read_numbers(batch, schema.intrinsics_key(camera), (4,), rows).float() for camera in cameras]
    poses = [read_numbers(batch, schema.extrinsics_key(camera), (7,), len(intrinsics[0])).float() for camera in cameras]
    return torch.stack(intrinsics, dim=1), torch.stack(poses, dim=1)


def fuse_views(batch: Mapping[str, Any], cameras: Sequence[str], workspace: Tensor) -> PointCloud:
    """One cloud for each row of a batch in the data contract.

    Args:
        batch: of each camera RGB (B, 3, H, W) in 0..1 or uint8, depth (B, 1, H, W) in millimetres, intrinsics (B, 4) in
            pixels and its pose (B, 7) in the base frame; cameras may differ in size.
        cameras: names of those to fuse.
        workspace: (3, 2) bounds in metres.

    Returns:
        The points inside the workspace, where depth was measured, see :func:`camera_checks.measured`.

    Raises:
        LlakeyError: naming the key and batch row if a camera or its calibration is missing, an image's size does not
            fit its intrinsics, a pose is none, colours or depths are in another unit, or a row has no point inside the
            workspace.
    """
    clouds = [_unproject(views, workspace) for views in _read_views(batch, cameras)]
    cloud = clouds[0] if len(clouds) == 1 else PointCloud(*map(torch.cat, zip(*map(_parts, clouds), strict=True)))
    rows = len(batch[schema.image_key(cameras[0])])
    empty = torch.bincount(cloud.rows, minlength=rows) == 0
    if empty.any():
        row = int(empty.nonzero()[0])
        raise LlakeyError(
            f"Expected points inside the workspace {workspace.tolist()} (metres), got a cloud with none from "
            f"{', '.join(map(schema.depth_key, cameras))} in batch row {row}; check the depth's unit (millimetres), "
            "the cameras' poses and the workspace."
        )
    return cloud


def _unproject(views: _Views, workspace: Tensor) -> PointCloud:
    size = views.depths.shape[-2:]
    check_calibration(views.intrinsics, views.poses, views.cameras, (size[0], size[1]))
    seen = measured(views.depths, views.cameras)
    depths = torch.where(seen, views.depths, 0.0) * MILLIMETRES
    matrices = geometry.intrinsics_to_matrix(views.intrinsics), geometry.pose_to_matrix(views.poses)
    points = geometry.unproject(depths, *matrices).flatten(1, 3)  # (B, C*H*W, 3)
    rows, place = (inside(points, workspace) & seen.flatten(1)).nonzero(as_tuple=True)
    colours = views.colours.permute(0, 1, 3, 4, 2).flatten(1, 3)
    return PointCloud(points[rows, place], colours[rows, place], rows)


def _parts(cloud: PointCloud) -> tuple[Tensor, Tensor, Tensor]:
    return cloud.points, cloud.colours, cloud.rows
