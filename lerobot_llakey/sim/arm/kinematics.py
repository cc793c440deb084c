"""Inverse kinematics by damped least squares, continuous along a path."""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.arm.panda import HOME_JOINTS, Robot

_DAMPING = 2e-4
_POSTURE_GAIN = 0.05
_LIMIT_MARGIN = 0.02
_LONGEST_STEP, _WIDEST_TURN = 0.1, 0.5


class Kinematics:
    """Forward and inverse kinematics of the arm on a scratch copy of the scene's data.

    The scratch data may be changed at will: it is also where planning tests configurations for collisions.
    """

    def __init__(self, model: mujoco.MjModel, robot: Robot) -> None:
        self.model, self.robot = model, robot
        self.scratch = mujoco.MjData(model)
        self._jacobian = np.zeros((6, model.nv))

    def place(self, joints: np.ndarray) -> None:
        """Put the scratch arm at joint angles (7,)."""
        self.scratch.qpos[self.robot.qpos] = joints
        mujoco.mj_kinematics(self.model, self.scratch)
        mujoco.mj_comPos(self.model, self.scratch)

    def forward(self, joints: np.ndarray) -> Pose:
        """Pose of the tool centre point at joint angles (7,)."""
        self.place(joints)
        return self.robot.tcp_pose(self.scratch)

    def solve(
        self,
        target: Pose,
        start: np.ndarray,
        iterations: int = 60,
        position_tolerance: float = 5e-4,
        angle_tolerance: float = 5e-3,
    ) -> np.ndarray | None:
        """Joint angles (7,) near ``start`` that bring the tool centre point to ``target``, or None.

        Tolerances are in metres and radians. The null space is drawn towards the home posture.
        """
        joints = start.copy()
        lower, upper = self.robot.limits[:, 0] + _LIMIT_MARGIN, self.robot.limits[:, 1] - _LIMIT_MARGIN
        target_rotation = target.rotation.as_matrix()
        for _ in range(iterations):
            self.place(joints)
            position = self.scratch.site_xpos[self.robot.tcp]
            rotation = self.scratch.site_xmat[self.robot.tcp].reshape(3, 3)
            error = np.concatenate(
                (target.position - position, Rotation.from_matrix(target_rotation @ rotation.T).as_rotvec())
            )
            if np.linalg.norm(error[:3]) < position_tolerance and np.linalg.norm(error[3:]) < angle_tolerance:
                return joints
            # Long reaches are linearised in pieces.
            error[:3] *= min(1.0, _LONGEST_STEP / max(float(np.linalg.norm(error[:3])), 1e-9))
            error[3:] *= min(1.0, _WIDEST_TURN / max(float(np.linalg.norm(error[3:])), 1e-9))
            mujoco.mj_jacSite(self.model, self.scratch, self._jacobian[:3], self._jacobian[3:], self.robot.tcp)
            jacobian = self._jacobian[:, self.robot.dofs]
            joints = np.clip(joints + _step(jacobian, error, joints, lower, upper), lower, upper)
        return None

    def solve_from_many(self, target: Pose, start: np.ndarray, rng: np.random.Generator) -> np.ndarray | None:
        """As :meth:`solve`, trying other starts (home, then random ones) where the first fails."""
        lower, upper = self.robot.limits.T
        starts = [start, HOME_JOINTS, *(rng.uniform(lower, upper) for _ in range(6))]
        for candidate in starts:
            joints = self.solve(target, candidate, iterations=100)
            if joints is not None:
                return joints
        return None


def _step(
    jacobian: np.ndarray, error: np.ndarray, joints: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """One damped step (7,); joints that it would drive past a limit are held and the others solved again."""
    free = np.ones(len(joints), dtype=bool)
    step = np.zeros_like(joints)
    for _ in range(3):
        reduced = jacobian[:, free]
        inverse = reduced.T @ np.linalg.inv(reduced @ reduced.T + _DAMPING * np.eye(6))
        posture = _POSTURE_GAIN * (HOME_JOINTS - joints)[free]
        step[:] = 0.0
        step[free] = inverse @ error + posture - inverse @ (reduced @ posture)
        blocked = free & (((joints + step) > upper) | ((joints + step) < lower))
        if not blocked.any():
            break
        free &= ~blocked
    return step
