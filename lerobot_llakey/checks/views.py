"""Where points fall in a camera's picture, and the other ways in which its matrix could have been meant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey import schema

OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])
_TOLERANCE = 0.03
"""Metres by which a camera on the hand may seem to move against it: clocks differ, matrices are rounded."""
_STILL = 0.002
"""Metres by which a camera that stands still may seem to move."""
_NEAREST = 0.01
_REACH = 0.3
"""Metres ahead of a camera of the point whose motion is looked at: it tells turns as well as places."""
_WXYZ = [1, 2, 3, 0]
"""Where x, y, z and w stand in a quaternion that begins with w."""


def project(extrinsics: np.ndarray, intrinsics: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (N, 3) of the base frame in pictures.

    Args:
        extrinsics: (N, 4, 4) camera to base.
        intrinsics: (N, 4) fx, fy, cx, cy in pixels.
        points: (N, 3) metres.

    Returns:
        Pixels (N, 2) as x and y, and depths (N,) in metres; pixels of points behind the camera mean nothing.
    """
    local = np.einsum("nji,nj->ni", extrinsics[:, :3, :3], points - extrinsics[:, :3, 3])
    depth = local[:, 2]
    ahead = np.where(depth > _NEAREST, depth, 1.0)[:, None]
    return local[:, :2] / ahead * intrinsics[:, :2] + intrinsics[:, 2:], depth


def in_picture(extrinsics: np.ndarray, intrinsics: np.ndarray, points: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Which of the points (N, 3) fall into pictures of this height and width: (N,) bool."""
    pixels, depth = project(extrinsics, intrinsics, points)
    height, width = size
    return (depth > _NEAREST) & (pixels >= 0).all(axis=1) & (pixels < (width, height)).all(axis=1)


def seen_share(extrinsics: np.ndarray, intrinsics: np.ndarray, points: np.ndarray, size: tuple[int, int]) -> float:
    """The share of :func:`in_picture`."""
    return float(in_picture(extrinsics, intrinsics, points, size).mean())


def readings(extrinsics: np.ndarray) -> dict[str, np.ndarray]:
    """What matrices (N, 4, 4) would be if they were meant in another way than camera to base in OpenCV axes."""
    inverse = np.linalg.inv(extrinsics)
    transposed = extrinsics.copy()
    transposed[:, :3, :3] = np.swapaxes(extrinsics[:, :3, :3], 1, 2)
    return {
        "base-to-camera": inverse,
        "OpenGL axes": extrinsics @ OPENGL,
        "a transposed rotation": transposed,
        "base-to-camera in OpenGL axes": inverse @ OPENGL,
    }


@dataclass(frozen=True)
class Moving:
    """How a camera moves against the hand.

    Attributes:
        given: metres, with the matrices as they are.
        tolerance: metres that count as none.
        better: the way of reading state or matrices in which it moves with the hand; "" if there is none.
    """

    given: float
    tolerance: float
    better: str


def motion_against_hand(extrinsics: np.ndarray, hand: np.ndarray) -> Moving | None:
    """How a camera of matrices (N, 4, 4) moves against the hand (N, 8); None for one that stands still."""
    if np.ptp(extrinsics[:, :3, 3], axis=0).max() < _STILL and np.ptp(extrinsics[:, :3, :3], axis=0).max() < _STILL:
        return None
    quaternion, place = hand[:, schema.QUATERNION], hand[:, schema.POSITION]
    if (np.linalg.norm(quaternion, axis=1) < 1e-6).any():
        return None
    given = _strays(extrinsics, place, quaternion)
    others = {name: _strays(other, place, quaternion) for name, other in readings(extrinsics).items()}
    others["camera-to-base beside a quaternion that begins with w"] = _strays(extrinsics, place, quaternion[:, _WXYZ])
    best = min(others, key=lambda name: others[name])
    return Moving(given, _TOLERANCE, best if others[best] <= _TOLERANCE and given > 2 * others[best] else "")


def _strays(extrinsics: np.ndarray, place: np.ndarray, quaternion: np.ndarray) -> float:
    """By how much, in metres, a point ahead of the camera moves against the hand: the ninth decile."""
    ahead = extrinsics[:, :3, 3] + _REACH * extrinsics[:, :3, 2]
    beside = extrinsics[:, :3, 3] + _REACH * extrinsics[:, :3, 0]
    hand = Rotation.from_quat(quaternion).inv()
    strays = []
    for points in (ahead, beside):
        local = hand.apply(points - place)
        strays.append(np.linalg.norm(local - np.median(local, axis=0), axis=1))
    return float(np.quantile(np.concatenate(strays), 0.9))
