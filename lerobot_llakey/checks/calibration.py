"""Cameras whose calibration is that of the pictures, and who see what the hand goes to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import Columns
from lerobot_llakey.checks.finding import Finding, told
from lerobot_llakey.checks.metadata import Size
from lerobot_llakey.checks.views import in_picture, motion_against_hand, readings, seen_share
from lerobot_llakey.geometry import pose_to_matrix

CENTRE = (0.25, 0.75)
"""Shares of a picture's size between which the principal point lies; pictures resized by two or more fall outside."""
FOCAL = (0.1, 6.0)
"""Shares of a picture's width between which the focal length lies: fields of view of 157 to 10 degrees."""
_SQUARE = 0.25
"""By how much the two focal lengths may differ: pixels are square, or a picture was squeezed a little."""
W_FIRST = "a quaternion that begins with w"
W_FIRST_ORDER = [0, 1, 2, 4, 5, 6, 3]
"""Where the numbers of a pose stand if its quaternion begins with w."""
_MOST_ROWS = 500
_SELDOM = 0.05
_MOSTLY = 0.8


def check_intrinsics(columns: Columns, sizes: Mapping[str, Size]) -> Iterator[Finding]:
    """Each camera's fx, fy, cx and cy are in pixels of its pictures.

    Args:
        columns: of a file.
        sizes: height and width of the cameras' pictures, by name.
    """
    for camera, (height, width) in sizes.items():
        key = schema.intrinsics_key(camera)
        if key not in columns:
            continue
        values = columns[key].astype(float)
        shares = values / (width, height, width, height)
        focal, centre = shares[:, :2], shares[:, 2:]
        right = ((centre > CENTRE[0]) & (centre < CENTRE[1]) & (focal > FOCAL[0]) & (focal < FOCAL[1])).all(axis=1)
        # Pixels are square or nearly so: a focal length of another camera's, or of a picture that was squeezed.
        right &= np.abs(values[:, 0] - values[:, 1]) <= _SQUARE * np.abs(values[:, 0])
        wrong = np.isfinite(values).all(axis=1) & ~right
        if wrong.any():
            expected = f"a focal length and a centre of pictures of {width}x{height} pixels for camera {camera}"
            advice = "rescale the intrinsics with the pictures, and write fx, fy, cx, cy"
            yield Finding(key, expected, told(values[wrong][0]), advice, columns.place(wrong))


def check_extrinsics(columns: Columns, cameras: Sequence[str]) -> Iterator[Finding]:
    """Each camera has a pose in metres, and none stands where another or the base does.

    Args:
        columns: of a file.
        cameras: names.
    """
    known = [camera for camera in cameras if schema.extrinsics_key(camera) in columns]
    advice = "give the camera's pose in the base's frame in metres, its quaternion as xyzw"
    for number, camera in enumerate(known):
        key = schema.extrinsics_key(camera)
        pose = columns[key].astype(float)
        finite = np.isfinite(pose).all(axis=1)
        length = np.linalg.norm(pose[:, schema.QUATERNION], axis=1)
        same = (np.abs(pose[:, schema.POSITION]) < 1e-6).all(axis=1)
        far = np.linalg.norm(pose[:, schema.POSITION], axis=1) > schema.FARTHEST
        for wrong, expected in (
            (np.abs(length - 1) > schema.UNIT_TOLERANCE, f"a unit quaternion for camera {camera}"),
            (same, f"a place other than the base's own for camera {camera}"),
            (far, f"a place within {schema.FARTHEST:g} m of the base for camera {camera}"),
        ):
            if (wrong & finite).any():
                yield Finding(key, expected, told(pose[wrong & finite][0]), advice, columns.place(wrong & finite))
        for other in known[:number]:
            if len(pose) and (np.abs(pose - columns[schema.extrinsics_key(other)]) < 1e-6).all():
                yield Finding(key, f"a place of its own for camera {camera}", f"that of {other}", advice)


def check_views(columns: Columns, sizes: Mapping[str, Size]) -> Iterator[Finding]:
    """Each camera sees what the hand goes to, and one that moves, moves with the hand.

    A pose is refused where nearly no keyframe can be seen from it and most could if it were read in another way: the
    other way round, or in OpenGL's axes. Where no way explains it, there is a warning: a camera may look aside.

    Args:
        columns: of a file.
        sizes: height and width of the cameras' pictures, by name.
    """
    if columns.hand is None or schema.ACTION not in columns or not len(columns):
        return
    rows = np.unique(np.linspace(0, len(columns) - 1, min(len(columns), _MOST_ROWS)).astype(int))
    places = columns[schema.ACTION][rows][:, schema.POSITION].astype(float)
    hands = columns.hand[rows].astype(float)
    sound = np.isfinite(places).all(axis=1) & np.isfinite(hands[:, :7]).all(axis=1)
    for camera, size in sizes.items():
        if not columns.has(schema.intrinsics_key(camera), schema.extrinsics_key(camera)):
            continue
        poses = columns[schema.extrinsics_key(camera)][rows].astype(float)
        intrinsics = columns[schema.intrinsics_key(camera)][rows].astype(float)
        usable = sound & np.isfinite(intrinsics).all(axis=1) & _is_pose(poses)
        if usable.sum() >= 3:
            yield from _check_view(camera, poses[usable], intrinsics[usable], places[usable], hands[usable], size)


def _check_view(
    camera: str, poses: np.ndarray, intrinsics: np.ndarray, places: np.ndarray, hands: np.ndarray, size: Size
) -> Iterator[Finding]:
    key, matrices = schema.extrinsics_key(camera), pose_to_matrix(poses)
    moving = motion_against_hand(matrices, hands)
    if moving is not None and moving.given > moving.tolerance:
        if moving.better or _moves_if_w_first(poses, hands, moving.tolerance):
            got = f"one that would if it were read as {moving.better or W_FIRST}"
            yield Finding(key, f"a camera {camera} that moves with the hand", got, "give camera-to-base poses")
        else:
            got = f"one that moves by {100 * moving.given:.0f} cm against it"
            expected = f"a camera {camera} that stands still or moves with the hand"
            advice = "check its calibration, and the order of the quaternion"
            yield Finding(key, expected, got, advice, certain=False)
        return
    given = seen_share(matrices, intrinsics, places, size)
    if given >= _SELDOM:
        return
    ways = readings(matrices) | {W_FIRST: pose_to_matrix(poses[:, W_FIRST_ORDER])}
    others = {name: in_picture(other, intrinsics, places, size).mean() for name, other in ways.items()}
    name = max(others, key=lambda name: others[name])
    expected = f"a camera {camera} that sees where the hand goes to"
    got = f"{100 * given:.0f} % of the keyframes in its picture"
    if others[name] >= _MOSTLY:
        got += f", but {100 * others[name]:.0f} % if it is read as {name}"
    advice = "give the camera's pose in the base's frame in OpenCV axes"
    yield Finding(key, expected, got, advice, certain=bool(others[name] >= _MOSTLY))


def _moves_if_w_first(poses: np.ndarray, hands: np.ndarray, tolerance: float) -> bool:
    moving = motion_against_hand(pose_to_matrix(poses[:, W_FIRST_ORDER]), hands)
    return moving is not None and moving.given <= tolerance


def _is_pose(poses: np.ndarray) -> np.ndarray:
    """Which rows (N, 7) are a position and a rotation; NaN never is."""
    length = np.linalg.norm(poses[:, schema.QUATERNION], axis=1)
    return np.isfinite(poses).all(axis=1) & (np.abs(length - 1) <= schema.UNIT_TOLERANCE)
