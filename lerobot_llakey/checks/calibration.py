"""Cameras whose calibration is that of the pictures, and who see what the hand goes to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import Columns
from lerobot_llakey.checks.finding import Finding, told
from lerobot_llakey.checks.views import in_picture, motion_against_hand, readings, seen_share

CENTRE = (0.25, 0.75)
"""Shares of a picture's size between which the principal point lies; pictures resized by two or more fall outside."""
FOCAL = (0.1, 6.0)
"""Shares of a picture's width between which the focal length lies: fields of view of 157 to 10 degrees."""
_ROUNDED = 0.01
"""By how much measured matrices may differ from ideal ones: they are rounded."""
_FARTHEST = 10.0
"""Metres from the base beyond which a camera's place is in millimetres."""
_MOST_ROWS = 500
_SELDOM = 0.05
_MOSTLY = 0.8

Size = tuple[int, int]


def check_intrinsics(columns: Columns, cameras: Sequence[str], sizes: Mapping[str, Size]) -> Iterator[Finding]:
    """Each matrix is [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels of the camera's pictures.

    Args:
        columns: of a file.
        cameras: names in the order of the calibration's rows.
        sizes: height and width of their pictures.
    """
    if not columns.has(schema.INTRINSICS):
        return
    key = schema.INTRINSICS
    for number, camera in enumerate(cameras):
        matrix = columns[key][:, number].astype(float)
        height, width = sizes[camera]
        finite = np.isfinite(matrix).all(axis=(1, 2))
        ideal = np.zeros_like(matrix)
        ideal[:, 0, 0], ideal[:, 1, 1], ideal[:, :2, 2] = matrix[:, 0, 0], matrix[:, 1, 1], matrix[:, :2, 2]
        ideal[:, 2, 2] = 1
        # Skew and mirror terms are pixels, small against the focal length; the last row is exact.
        scale = np.maximum(np.abs(matrix[:, 0, 0]), 1.0)[:, None, None] * np.array([[1, 1, 1], [1, 1, 1], [0, 0, 0]])
        formed = (np.abs(matrix - ideal) <= _ROUNDED * np.maximum(scale, 0.1)).all(axis=(1, 2))
        wrong = finite & ~formed
        if wrong.any():
            expected = f"[[fx, 0, cx], [0, fy, cy], [0, 0, 1]] for camera {camera}"
            advice = "correct the calibration"
            yield Finding(key, expected, told(matrix[wrong][0]), advice, columns.place(wrong))
            continue
        shares = matrix[:, :2, 2] / (width, height)
        focal = matrix[:, (0, 1), (0, 1)] / (width, height)
        wrong = finite & ~((shares > CENTRE[0]) & (shares < CENTRE[1])).all(axis=1)
        wrong |= finite & ~((focal > FOCAL[0]) & (focal < FOCAL[1])).all(axis=1)
        if wrong.any():
            expected = f"a focal length and a centre of pictures of {width}x{height} pixels for camera {camera}"
            advice = "rescale the intrinsics with the pictures"
            yield Finding(key, expected, told(matrix[wrong][0]), advice, columns.place(wrong))


def check_extrinsics(columns: Columns, cameras: Sequence[str]) -> Iterator[Finding]:
    """Each matrix is a rigid transform from camera to base, and no camera stands where another or the base does.

    Args:
        columns: of a file.
        cameras: names in the order of the calibration's rows.
    """
    if not columns.has(schema.EXTRINSICS):
        return
    key, matrices = schema.EXTRINSICS, columns[schema.EXTRINSICS].astype(float)
    advice = "give camera-to-base matrices in metres"
    for number, camera in enumerate(cameras):
        matrix = matrices[:, number]
        finite = np.isfinite(matrix).all(axis=(1, 2))
        same = (np.abs(matrix - np.eye(4)) < 1e-6).all(axis=(1, 2))
        far = np.linalg.norm(matrix[:, :3, 3], axis=1) > _FARTHEST
        for wrong, expected in (
            (~_is_rigid(matrix), f"a rotation, a place and the last row 0 0 0 1 for camera {camera}"),
            (same, f"a place other than the base's own for camera {camera}"),
            (far, f"a place within {_FARTHEST:g} m of the base for camera {camera}"),
        ):
            if (wrong & finite).any():
                got = "the identity" if wrong is same else told(matrix[wrong & finite][0])
                yield Finding(key, expected, got, advice, columns.place(wrong & finite))
        for other in range(number):
            if len(matrix) and (np.abs(matrix - matrices[:, other]) < 1e-6).all():
                yield Finding(key, f"a place of its own for camera {camera}", f"that of {cameras[other]}", advice)


def check_views(columns: Columns, cameras: Sequence[str], sizes: Mapping[str, Size]) -> Iterator[Finding]:
    """Each camera sees what the hand goes to, and one that moves, moves with the hand.

    A matrix is refused where nearly no keyframe can be seen through it and most could if it were read in another way:
    the other way round, or in OpenGL's axes. Where no way explains it, there is a warning: a camera may look aside.

    Args:
        columns: of a file.
        cameras: names in the order of the calibration's rows.
        sizes: height and width of their pictures.
    """
    if not columns.has(schema.INTRINSICS, schema.EXTRINSICS, schema.ACTION, schema.STATE) or not len(columns):
        return
    rows = np.unique(np.linspace(0, len(columns) - 1, min(len(columns), _MOST_ROWS)).astype(int))
    matrices, intrinsics = columns[schema.EXTRINSICS][rows], columns[schema.INTRINSICS][rows]
    places = columns[schema.ACTION][rows][:, schema.POSITION].astype(float)
    state = columns[schema.STATE][rows].astype(float)
    usable = np.isfinite(places).all(axis=1) & np.isfinite(state[:, :7]).all(axis=1)
    usable &= _is_rigid(matrices).all(axis=1) & np.isfinite(intrinsics).all(axis=(1, 2, 3))
    if usable.sum() < 3:
        return
    key = schema.EXTRINSICS
    for number, camera in enumerate(cameras):
        seen = matrices[usable, number].astype(float), intrinsics[usable, number].astype(float)
        moving = motion_against_hand(seen[0], state[usable])
        if moving is not None and moving.given > moving.tolerance:
            if moving.better:
                got = f"one that would if it were read as {moving.better}"
                yield Finding(key, f"a camera {camera} that moves with the hand", got, "give camera-to-base matrices")
            else:
                got = f"one that moves by {100 * moving.given:.0f} cm against it"
                expected = f"a camera {camera} that stands still or moves with the hand"
                advice = "check its calibration, and the order of the quaternion"
                yield Finding(key, expected, got, advice, certain=False)
            continue
        given = seen_share(*seen, places[usable], sizes[camera])
        if given >= _SELDOM:
            continue
        others = {name: in_picture(other, seen[1], places[usable], sizes[camera]).mean()
                  for name, other in readings(seen[0]).items()}  # fmt: skip
        name = max(others, key=lambda name: others[name])
        expected = f"a camera {camera} that sees where the hand goes to"
        got = f"{100 * given:.0f} % of the keyframes in its picture"
        if others[name] >= _MOSTLY:
            got += f", but {100 * others[name]:.0f} % if it is read as {name}"
        yield Finding(key, expected, got, "give camera-to-base matrices in OpenCV axes, in the cameras' order",
                      certain=bool(others[name] >= _MOSTLY))  # fmt: skip


def _is_rigid(matrices: np.ndarray) -> np.ndarray:
    """Which matrices (..., 4, 4) are a rotation and a translation: (...) bool; NaN never is."""
    turn = matrices[..., :3, :3].astype(float)
    square = np.abs(np.swapaxes(turn, -1, -2) @ turn - np.eye(3)).max(axis=(-2, -1))
    bottom = np.abs(matrices[..., 3, :] - (0.0, 0.0, 0.0, 1.0)).max(axis=-1)
    with np.errstate(invalid="ignore"):
        return (square < _ROUNDED) & (bottom < _ROUNDED) & (np.linalg.det(np.nan_to_num(turn)) > 0)
