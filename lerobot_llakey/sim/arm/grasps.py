"""Where a thing sits in a hand that points down, and where the hand must go to bring the thing somewhere upright."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down

MOST_TILT = np.deg2rad(35)
"""Radians by which a hand leans at most to set a tilted thing upright."""


@dataclass(frozen=True)
class Grasp:
    """A thing in a hand.

    Attributes:
        offset: (3,) metres, the thing's origin in the tool's frame.
        axis: (3,) unit vector, the thing's z axis in the tool's frame.
    """

    offset: np.ndarray
    axis: np.ndarray

    @staticmethod
    def of(tool: Pose, thing: Pose) -> Grasp:
        """The grip of a tool on a thing as they stand."""
        local = tool.inverse() @ thing
        return Grasp(local.position, local.rotation.as_matrix()[:, 2])

    @staticmethod
    def upright(height: float) -> Grasp:
        """The grip of a hand that takes an upright thing from straight above, at a height over its origin (metres)."""
        return Grasp(np.array((0.0, 0.0, height)), np.array((0.0, 0.0, -1.0)))

    @property
    def tilt(self) -> float:
        """Radians by which the thing would lean in a hand that points straight down."""
        return float(np.arccos(np.clip(-self.axis[2], -1.0, 1.0)))

    def hand(self, thing: np.ndarray, yaw: float) -> Pose:
        """The tool's pose, at a yaw (radians), that brings the thing to a position (3,), its axis upright."""
        down = Rotation.from_quat(top_down(yaw))
        leaning = down.apply(self.axis)
        turn = np.cross(leaning, (0.0, 0.0, 1.0))
        sine, angle = np.linalg.norm(turn), np.arctan2(np.linalg.norm(turn), leaning[2])
        if sine > 1e-9:
            down = Rotation.from_rotvec(turn / sine * min(angle, MOST_TILT)) * down
        return Pose(np.asarray(thing) - down.apply(self.offset), down.as_quat())


def hand_yaw(tool: Pose) -> float:
    """Yaw of a hand that points down, in (-pi/2, pi/2], half a turn being the same to a gripper."""
    matrix = tool.rotation.as_matrix()
    yaw = np.arctan2(matrix[1, 0], matrix[0, 0])
    return float(np.pi / 2 - (np.pi / 2 - yaw) % np.pi)
