"""Carrying out one keyframe action: plan, follow the path, move the gripper, come to rest."""

from __future__ import annotations

import numpy as np

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.clock import Clock
from lerobot_llakey.sim.world import World

_PEAK_JOINT_SPEED = 1.6
"""Radians a second of the fastest joint, below the Panda's limit of 2.17."""
_SHORTEST_MOVE = 0.24
_REST_SECONDS = 0.36
"""Rest after each action: three frames at 10 fps, by which keyframes are recognised."""
_ARRIVE_SECONDS, _GRIPPER_SECONDS = 0.6, 0.8
_STILL_ARM, _STILL_FINGERS = 0.02, 0.002


class Motion:
    """Moves the arm of a world.

    Args:
        world: the scene to act in.
        clock: lets its time go by.
    """

    def __init__(self, world: World, clock: Clock) -> None:
        self.world, self.clock = world, clock

    def execute(self, target: Pose, gripper_open: bool, ignore_collision: bool) -> None:
        """Bring the tool to a pose, then open or close the gripper, then rest.

        Args:
            target: pose of the tool centre point in the base frame.
            gripper_open: state of the gripper afterwards.
            ignore_collision: whether the path may touch things.

        Raises:
            PlanningError: if there is no path; nothing has moved then.
        """
        self.follow(self.plan(target, ignore_collision))
        self.set_gripper(gripper_open)
        self.rest()

    def plan(self, target: Pose, ignore_collision: bool) -> np.ndarray:
        """A joint path (N, 7) from where the arm is to a pose of the tool, with what the hand holds.

        Raises:
            PlanningError: if there is none.
        """
        world = self.world
        return world.planner.plan(world.data, target, ignore_collision, world.carried(), world.rng)

    def follow(self, path: np.ndarray) -> None:
        """Servo along a joint path (N, 7), starting and ending at rest (minimum jerk in the path's length)."""
        world, robot, timestep = self.world, self.world.robot, self.clock.timestep
        lengths = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(path, axis=0)).max(axis=1))))
        # The speed of a minimum-jerk move peaks at 1.875 times its mean.
        duration = max(_SHORTEST_MOVE, 1.875 * lengths[-1] / _PEAK_JOINT_SPEED)
        times = np.linspace(0, 1, max(2, round(duration / timestep)) + 1)
        progress = times**3 * (10 - 15 * times + 6 * times**2) * lengths[-1]
        targets = np.stack([np.interp(progress, lengths, path[:, joint]) for joint in range(path.shape[1])], axis=1)
        velocities = np.gradient(targets, timestep, axis=0)
        for joints, velocity in zip(targets[1:], velocities[1:], strict=True):
            world.data.ctrl[robot.actuators] = joints + robot.velocity_gain * velocity
            self.clock.step()
        world.data.ctrl[robot.actuators] = path[-1]
        for _ in range(round(_ARRIVE_SECONDS / timestep)):
            if np.abs(world.data.qvel[robot.dofs]).max() < _STILL_ARM:
                break
            self.clock.step()

    def set_gripper(self, gripper_open: bool) -> None:
        """Open or close the gripper, unless it was last told to be so, and wait until its fingers stand still."""
        world, robot, timestep = self.world, self.world.robot, self.clock.timestep
        if gripper_open != world.gripper_closed:
            return
        world.data.ctrl[robot.finger_actuators] = robot.open_target if gripper_open else 0.0
        for step in range(round(_GRIPPER_SECONDS / timestep)):
            self.clock.step()
            still = np.abs(world.data.qvel[robot.finger_dofs]).max() < _STILL_FINGERS
            if still and step * timestep > 0.2:
                break

    def rest(self) -> None:
        """Let things come to rest, long enough for the keyframe to be recognised."""
        self.clock.advance(_REST_SECONDS)
