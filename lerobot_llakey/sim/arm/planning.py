"""Paths of the arm: a straight line of the tool where it is free, a sampling-based planner where it is not."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.arm.kinematics import Kinematics
from lerobot_llakey.sim.arm.panda import Robot
from lerobot_llakey.sim.arm.rrt_connect import rrt_connect
from lerobot_llakey.sim.mujoco_poses import wxyz

_STEP_METRES, _STEP_RADIANS = 0.03, 0.15
_MAX_JOINT_STEP = 0.6
"""Radians between neighbouring waypoints of a straight line beyond which the arm would jump to another posture."""
_MAX_JOINT_DETOUR = 1.0
"""Radians that a joint may turn, unchecked, where collisions are ignored and the straight line is out of reach."""
_PENETRATION = 0.002
"""Metres of overlap that count as a collision: objects at rest touch their support."""


@dataclass(frozen=True)
class Held:
    """A free body that moves with the hand while planning.

    Attributes:
        body: MuJoCo's id of the body.
        qpos: address of its free joint in qpos.
        offset: its pose in the tool's frame.
    """

    body: int
    qpos: int
    offset: Pose


class PlanningError(RuntimeError):
    """No path: ``reason`` is "unreachable" or "collision"."""

    def __init__(self, reason: str) -> None:
        super().__init__(f"Expected a reachable, collision-free pose, got one that is {reason}; choose another pose.")
        self.reason = reason


class Planner:
    """Plans joint paths in a snapshot of the scene.

    Args:
        kinematics: the scene's kinematics, whose scratch data is used.
        robot: the arm's indices.
    """

    def __init__(self, kinematics: Kinematics, robot: Robot) -> None:
        self.kinematics, self.robot, self.model = kinematics, robot, kinematics.model
        self._is_robot = np.zeros(self.model.ngeom, dtype=bool)
        self._is_robot[robot.geoms] = True

    def plan(
        self,
        data: mujoco.MjData,
        target: Pose,
        ignore_collision: bool,
        held: Iterable[Held],
        rng: np.random.Generator,
    ) -> np.ndarray:
        """A joint path (N, 7) from the present state to a tool pose.

        Args:
            data: the scene's present state; it is not changed.
            target: pose of the tool centre point in the base frame.
            ignore_collision: whether touching things on the way is allowed.
            held: bodies carried along.
            rng: seeds the search.

        Raises:
            PlanningError: if the pose is out of reach, or every path tried collides.
        """
        # Before any sample is planned: a straight line to far away would hold a sample every 3 cm.
        if math.hypot(*target.position) > self.robot.longest_reach:
            raise PlanningError("unreachable")
        held = tuple(held)
        self._snapshot(data)
        start = self.robot.joints(data)
        straight = self._straight_line(self.robot.tcp_pose(data), target, start)
        if straight is not None and (ignore_collision or self._is_free(straight, start, held)):
            return straight
        goal = self.kinematics.solve_from_many(target, start, rng)
        if goal is None:
            raise PlanningError("unreachable")
        if ignore_collision and np.abs(goal - start).max() < _MAX_JOINT_DETOUR:
            return np.stack((start, goal))
        allowed = self._contacts(start, held)
        if self._contacts(goal, held) - allowed:
            raise PlanningError("collision")
        path = rrt_connect(
            start, goal, self.robot.limits, lambda joints: not self._contacts(joints, held) - allowed, rng
        )
        if path is None:
            raise PlanningError("collision")
        return path

    def fits(self, data: mujoco.MjData, target: Pose, rng: np.random.Generator) -> bool:
        """Whether the arm reaches a tool pose at which its open hand overlaps nothing in the present state."""
        self._snapshot(data)
        goal = self.kinematics.solve_from_many(target, self.robot.joints(data), rng)
        if goal is None:
            return False
        self.kinematics.scratch.qpos[self.robot.finger_qpos] = self.robot.open_target
        return not self._contacts(goal, ())

    def _snapshot(self, data: mujoco.MjData) -> None:
        scratch = self.kinematics.scratch
        scratch.qpos[:], scratch.qvel[:] = data.qpos, 0.0
        scratch.mocap_pos[:], scratch.mocap_quat[:] = data.mocap_pos, data.mocap_quat

    def _straight_line(self, start: Pose, target: Pose, joints: np.ndarray) -> np.ndarray | None:
        distance, angle = start.distance(target)
        count = max(2, int(np.ceil(max(distance / _STEP_METRES, angle / _STEP_RADIANS))))
        slerp = Slerp([0, 1], Rotation.from_quat(np.stack((start.quaternion, target.quaternion))))
        path = [joints]
        for fraction in np.linspace(0, 1, count + 1)[1:]:
            position = (1 - fraction) * start.position + fraction * target.position
            solution = self.kinematics.solve(Pose(position, slerp(fraction).as_quat()), path[-1], iterations=30)
            if solution is None or np.abs(solution - path[-1]).max() > _MAX_JOINT_STEP:
                return None
            path.append(solution)
        return np.stack(path)

    def _is_free(self, path: np.ndarray, start: np.ndarray, held: tuple[Held, ...]) -> bool:
        allowed = self._contacts(start, held)
        return not any(self._contacts(joints, held) - allowed for joints in path[1:])

    def _contacts(self, joints: np.ndarray, held: tuple[Held, ...]) -> set[tuple[int, int]]:
        """Pairs of geoms in which the arm, or what it holds, overlaps the rest of the scene."""
        model, scratch = self.model, self.kinematics.scratch
        scratch.qpos[self.robot.qpos] = joints
        mujoco.mj_kinematics(model, scratch)
        if held:
            tool = self.robot.tcp_pose(scratch)
            for body in held:
                pose = tool @ body.offset
                scratch.qpos[body.qpos : body.qpos + 7] = (*pose.position, *wxyz(pose.quaternion))
            mujoco.mj_kinematics(model, scratch)
        mujoco.mj_comPos(model, scratch)
        mujoco.mj_collision(model, scratch)
        moving = self._is_robot.copy()
        for body in held:
            moving[model.geom_bodyid == body.body] = True
        contact = scratch.contact
        pairs = contact.geom[contact.dist < -_PENETRATION]
        return {(int(a), int(b)) for a, b in pairs if moving[a] != moving[b]}
