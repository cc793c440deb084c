"""A cloud and gripper frames from one oblique orthographic viewpoint, drawn with numpy and OpenCV."""

from __future__ import annotations

import math

import cv2
import numpy as np

from lerobot_llakey import geometry, schema

_BACKGROUND = 24
_FINGER, _STEM = 0.045, 0.11
"""Metres from the fingertips to the palm and to the stem's end."""
_OPENING = {True: 0.08, False: 0.02}
"""Metres between the fingers that are drawn for an open and for a closed gripper."""


class ObliqueView:
    """An orthographic camera that stages at a point from the front right, from above.

    Args:
        centre: (3,) metres, shown in the picture's middle.
        span: metres along the picture's height.
        width: pixels.
        height: pixels.
        azimuth: degrees from the base's x axis, counter-clockwise, at which the camera stands.
        elevation: degrees above the table.
    """

    def __init__(
        self,
        centre: np.ndarray,
        span: float,
        width: int,
        height: int,
        azimuth: float = -50.0,
        elevation: float = 35.0,
    ) -> None:
        turn, rise = math.radians(azimuth), math.radians(elevation)
        towards = np.array([math.cos(rise) * math.cos(turn), math.cos(rise) * math.sin(turn), math.sin(rise)])
        right = np.array([-math.sin(turn), math.cos(turn), 0.0])
        # Rows: to the right, downwards, away from the camera.
        self._axes = np.stack((right, -np.cross(towards, right), -towards))
        self._centre, self._scale = np.asarray(centre, dtype=np.float64), height / span
        self.width, self.height = width, height

    def project(self, points: np.ndarray) -> np.ndarray:
        """Column, row and distance from the centre's plane (..., 3), in pixels, of points (..., 3) in metres."""
        local = (np.asarray(points, dtype=np.float64) - self._centre) @ self._axes.T * self._scale
        return local + np.array([self.width / 2, self.height / 2, 0.0])

    def draw_cloud(self, points: np.ndarray, colours: np.ndarray, size: int = 2) -> np.ndarray:
        """A new picture (height, width, 3) uint8 of points (M, 3) with colours (M, 3) in 0..1, size pixels wide."""
        picture = np.full((self.height, self.width, 3), _BACKGROUND, dtype=np.uint8)
        places = self.project(points)
        order = places[:, 2].argsort(kind="stable")[::-1]
        columns, rows = places[order, :2].round().astype(np.int64).T
        paint = (np.clip(colours[order], 0.0, 1.0) * 255).astype(np.uint8)
        # The size x size offsets of one point lie together, so that a farther point never covers a nearer one.
        offsets = np.stack(np.meshgrid(np.arange(size), np.arange(size), indexing="ij")).reshape(2, -1)
        rows, columns = (rows[:, None] + offsets[0]).ravel(), (columns[:, None] + offsets[1]).ravel()
        shown = (rows >= 0) & (rows < self.height) & (columns >= 0) & (columns < self.width)
        picture[rows[shown], columns[shown]] = np.repeat(paint, size * size, axis=0)[shown]
        return picture

    def draw_gripper(self, picture: np.ndarray, action: np.ndarray, colour: tuple[int, int, int], pen: int = 2) -> None:
        """Draw the hand of an action (9,) over a picture: fingers, palm and stem, and a dot between the fingertips.

        Args:
            picture: (height, width, 3) uint8, changed in place.
            action: (9,) in the data contract.
            colour: RGB.
            pen: width of the lines in pixels.
        """
        for line in gripper_lines(action):
            ends = self.project(line)[:, :2].round().astype(np.int32)
            cv2.polylines(picture, [ends[:, None]], False, (0, 0, 0), pen + 2, cv2.LINE_AA)
            cv2.polylines(picture, [ends[:, None]], False, colour, pen, cv2.LINE_AA)
        column, row, _ = self.project(np.asarray(action)[schema.POSITION]).round().astype(int).tolist()
        cv2.circle(picture, (column, row), pen + 2, colour, -1, cv2.LINE_AA)


def gripper_lines(action: np.ndarray) -> list[np.ndarray]:
    """Two lines (N, 3) in metres, base frame, that show an action's (9,) hand: finger, palm, finger; and the stem.

    The fingers open along the hand's y axis; z points out of the hand.
    """
    action = np.asarray(action, dtype=np.float64)
    half = _OPENING[bool(action[schema.GRIPPER] > 0.5)] / 2
    fingers = [(0, -half, 0), (0, -half, -_FINGER), (0, half, -_FINGER), (0, half, 0)]
    pose = geometry.Pose(action[schema.POSITION], action[schema.QUATERNION])
    return [pose.apply(fingers), pose.apply([(0, 0, -_FINGER), (0, 0, -_STEM)])]
