"""Calibration of cameras that do not move, from a person's file, for recordings that lack it.

The file is YAML (or JSON, which YAML reads too), by camera name::

    front:
      intrinsics: [616.4, 616.2, 321.7, 240.3]     # fx fy cx cy in pixels of its recorded image, or 3x3
      extrinsics: [0.9, 0.1, 0.6, -0.68, -0.68, 0.19, 0.19]     # x y z qx qy qz qw of the camera in the base frame,
                                                                # OpenCV axes, metres; or 4x4 camera-to-base
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.files import reading
from lerobot_llakey.geometry import matrix_to_pose

_RIGID = 0.02
"""By how much a written rotation may differ from an ideal one; they are rounded."""


@dataclass(frozen=True)
class CameraCalibration:
    """Of one camera.

    Attributes:
        intrinsics: (4,) fx, fy, cx, cy in pixels.
        extrinsics: (7,) pose in the base frame, OpenCV axes.
    """

    intrinsics: np.ndarray
    extrinsics: np.ndarray


def read_calibration(path: Path, cameras: Collection[str]) -> dict[str, CameraCalibration]:
    """The calibration of some of a recording's cameras.

    Args:
        path: of the file.
        cameras: the recording's.

    Raises:
        MissingFileError: if there is no such file.
        LlakeyError: naming the camera that the recording lacks, or whose numbers make no sense.
    """
    if not path.is_file():
        raise MissingFileError(f"Expected a calibration in {path}, found no file; check --calibration.")
    with reading(path, "YAML or JSON file"):
        content: Any = yaml.safe_load(path.read_text(encoding="utf-8"))
    if not isinstance(content, dict) or not content:
        raise LlakeyError(
            f"Expected cameras with intrinsics and extrinsics in {path}, got {content!r:.80}; write one entry a camera."
        )
    unknown = [str(name) for name in content if name not in cameras]
    if unknown:
        raise LlakeyError(
            f"Expected calibrations of the cameras {', '.join(cameras)} in {path}, got {', '.join(unknown)}; use the "
            "recording's names."
        )
    return {str(name): _camera(str(name), entry, path) for name, entry in content.items()}


def _camera(name: str, entry: Any, path: Path) -> CameraCalibration:
    if not isinstance(entry, dict) or set(entry) != {"intrinsics", "extrinsics"}:
        got = ", ".join(map(str, entry)) if isinstance(entry, dict) else repr(entry)
        raise LlakeyError(f"Expected intrinsics and extrinsics of camera {name} in {path}, got {got}; give both.")
    intrinsics = _numbers(name, "intrinsics", entry["intrinsics"], ((4,), (3, 3)), path)
    extrinsics = _numbers(name, "extrinsics", entry["extrinsics"], ((7,), (4, 4)), path)
    if intrinsics.ndim == 2:
        flat = intrinsics[[0, 1, 0, 1], [0, 1, 2, 2]]
        ideal = np.array([[flat[0], 0, flat[2]], [0, flat[1], flat[3]], [0, 0, 1]])
        if np.abs(intrinsics - ideal).max() > 0.01 * max(abs(flat[0]), 1.0) or intrinsics[2, 2] != 1:
            raise LlakeyError(
                f"Expected intrinsics [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] of camera {name} in {path}, got "
                f"{intrinsics.tolist()}; give a pinhole camera without skew."
            )
        intrinsics = flat
    if extrinsics.ndim == 2:
        turn = extrinsics[:3, :3]
        rigid = np.abs(turn.T @ turn - np.eye(3)).max() < _RIGID and np.linalg.det(turn) > 0
        if not rigid or np.abs(extrinsics[3] - (0, 0, 0, 1)).max() > 1e-6:
            raise LlakeyError(
                f"Expected a rotation, a position in metres and the last row 0 0 0 1 as extrinsics of camera {name} in "
                f"{path}, got {extrinsics.tolist()}; give a camera-to-base matrix."
            )
        extrinsics = matrix_to_pose(extrinsics)
    length = float(np.linalg.norm(extrinsics[3:]))
    if abs(length - 1) > schema.UNIT_TOLERANCE:
        raise LlakeyError(
            f"Expected a unit quaternion qx, qy, qz, qw as the last four extrinsics of camera {name} in {path}, got "
            f"{extrinsics[3:].tolist()} of length {length:.3g}; correct it."
        )
    extrinsics[3:] /= length
    return CameraCalibration(intrinsics.astype(np.float32), extrinsics.astype(np.float32))


def _numbers(name: str, what: str, value: Any, shapes: tuple[tuple[int, ...], ...], path: Path) -> np.ndarray:
    try:
        numbers = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.array(np.nan)
    if numbers.shape not in shapes or not np.isfinite(numbers).all():
        wanted = " or ".join("x".join(map(str, shape)) for shape in shapes)
        raise LlakeyError(
            f"Expected {wanted} finite numbers as {what} of camera {name} in {path}, got {value!r:.120}; correct them."
        )
    return numbers
