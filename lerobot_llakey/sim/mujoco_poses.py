"""The simulator's edge: poses in and out of MuJoCo, whose quaternions are wxyz."""

from __future__ import annotations

import mujoco
import numpy as np

from lerobot_llakey.geometry import Pose


def wxyz(quaternion_xyzw: np.ndarray) -> np.ndarray:
    """MuJoCo's order of a quaternion (4,) xyzw."""
    return np.roll(quaternion_xyzw, 1)


def xyzw(quaternion_wxyz: np.ndarray) -> np.ndarray:
    """Our order of a quaternion (4,) wxyz."""
    return np.roll(quaternion_wxyz, -1)


def about_z(angle: float) -> tuple[float, float, float, float]:
    """MuJoCo's quaternion (w, x, y, z) of a turn about z in radians."""
    return float(np.cos(angle / 2)), 0.0, 0.0, float(np.sin(angle / 2))


def body_pose(data: mujoco.MjData, body: int) -> Pose:
    """Pose of a body's frame in the base frame."""
    return Pose(data.xpos[body], xyzw(data.xquat[body]))


def site_pose(data: mujoco.MjData, site: int) -> Pose:
    """Pose of a site in the base frame."""
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, data.site_xmat[site])
    return Pose(data.site_xpos[site], xyzw(quaternion))
