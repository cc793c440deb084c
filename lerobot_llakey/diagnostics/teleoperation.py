"""Recordings of known truth that never rest: our simulator driven by a noisy operator.

The operator goes for the expert's waypoints as a person at a leader arm does: the hand drifts off the straight line,
trembles, hesitates, and turns to the next waypoint without stopping. Sensors add noise, or read in an encoder's steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.geometry import Pose, continuous_quaternions
from lerobot_llakey.hand import joint_columns
from lerobot_llakey.keyframes.motion import Motion
from lerobot_llakey.sim.arm.planning import PlanningError
from lerobot_llakey.sim.settings import MAX_STEPS
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks.base import Waypoint

_FASTEST = 1.2
"""Radians a second of the fastest joint."""
_STEADY = (0.0, 0.012)
"""Metres that a hand drifts off its line."""
_TREMOR_HERTZ, _TREMOR = (6.0, 11.0), 0.0015
"""Frequencies of a hand's tremor, and its amplitude in radians of a joint."""
_HESITATIONS, _HESITATION_SECONDS = 0.35, (0.15, 0.6)
"""The chance of a hesitation in a move, and how long one is."""
_FOLLOW_SECONDS = 0.12
"""The time in which the operator's hand and the arm behind it follow what was meant."""
_CORNER_SPEED = (0.2, 0.6)
"""The share of a move's speed that is left where it turns into the next one."""
_SAME_METRES, _SAME_RADIANS = 0.03, 0.2
_AIMS = 0.05
"""Metres: who has no further to go stops and aims first."""
_GRIPPER_SECONDS, _AFTER_GRIPPER = 0.8, (0.0, 0.15)
_FINGERS_DONE = 0.02
"""The share of its travel that a gripper that is done has left."""
_CLOSEST_WITHIN = 0.5
"""Seconds about the end of a move within which the hand comes closest to its waypoint."""


@dataclass(frozen=True)
class Sensors:
    """How a recording is taken.

    Attributes:
        fps: frames a second.
        noise: radians of each joint, standard deviation.
        step: radians of an encoder's steps; 0 for none.
    """

    fps: float = 10.0
    noise: float = 0.002
    step: float = 0.0


@dataclass(frozen=True)
class Recording:
    """A foreign recording whose truth is known.

    Attributes:
        motion: what the rules look at.
        truth: frame at which each of the waypoints was done with, increasing; the last one is the last frame.
        success: whether the task was done.
        task, seed, variation: the scene.
    """

    motion: Motion
    truth: list[int]
    waypoints: list[Waypoint]
    success: bool
    task: str
    seed: int
    variation: int


class Operator:
    """Drives the arm of a simulation that was freshly reset."""

    def __init__(self, simulation: Simulation, rng: np.random.Generator) -> None:
        self._simulation, self._rng = simulation, rng
        robot, world = simulation.world.robot, simulation.world
        self._target = robot.joints(world.data).copy()
        self._smooth, self._rate = self._target.copy(), np.zeros_like(self._target)
        self._phases = rng.uniform(0, 2 * np.pi, (2, len(self._target)))
        self._hertz = rng.uniform(*_TREMOR_HERTZ, (2, len(self._target)))
        self._speed = 0.0

    def step(self) -> None:
        """One time step: the hand follows the target with a delay, and trembles."""
        world, clock = self._simulation.world, self._simulation.clock
        omega = 2 / _FOLLOW_SECONDS  # critically damped
        acceleration = omega**2 * (self._target - self._smooth) - 2 * omega * self._rate
        self._rate += acceleration * clock.timestep
        self._smooth += self._rate * clock.timestep
        waves = np.sin(2 * np.pi * self._hertz * world.data.time + self._phases).sum(axis=0)
        robot = world.robot
        world.data.ctrl[robot.actuators] = self._smooth + _TREMOR / 2 * waves + robot.velocity_gain * self._rate
        clock.step()

    def follow(self, path: np.ndarray, end_speed: float) -> None:
        """Go along a joint path (N, 7), from the present speed to a share of the operator's speed at its end."""
        rng, timestep = self._rng, self._simulation.clock.timestep
        lengths = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(path, axis=0)).max(axis=1))))
        fastest = _FASTEST * rng.uniform(0.5, 1.0)
        pause_at = rng.uniform(0.25, 0.7) * lengths[-1] if rng.random() < _HESITATIONS else np.inf
        pause = rng.uniform(*_HESITATION_SECONDS)
        drift = rng.normal(0, 1, path.shape[1]) * rng.uniform(*_STEADY)
        done, slope = 0.0, 2.5  # radians a second squared
        speed = self._speed
        while done < lengths[-1] - 1e-4:
            left = lengths[-1] - done
            wanted = min(fastest, np.sqrt((end_speed * fastest) ** 2 + 2 * slope * left))
            if pause_at < done + 0.5 * speed**2 / slope and pause > 0:
                wanted, pause = 0.02, pause - timestep
            speed += np.clip(wanted - speed, -2 * slope * timestep, slope * timestep)
            speed = max(speed, 0.02)
            done = min(lengths[-1], done + speed * timestep)
            leg = min(int(np.searchsorted(lengths, done, side="right")), len(path) - 1)
            share = (done - lengths[leg - 1]) / max(lengths[leg] - lengths[leg - 1], 1e-9)
            here = path[leg - 1] + share * (path[leg] - path[leg - 1])
            self._target = here + drift * np.sin(np.pi * done / max(lengths[-1], 1e-9)) ** 2
            self.step()
        self._speed = speed if end_speed else 0.0

    def settle(self) -> None:
        """Wait until the hand is near its target: it has to be, to grasp."""
        for _ in range(round(0.6 / self._simulation.clock.timestep)):
            if np.abs(self._target - self._smooth).max() < 0.004:
                break
            self.step()

    def grip(self, gripper_open: bool) -> None:
        """Open or close the gripper, and wait for the fingers, no longer."""
        world, timestep, robot = self._simulation.world, self._simulation.clock.timestep, self._simulation.world.robot
        world.data.ctrl[robot.finger_actuators] = robot.open_target if gripper_open else 0.0
        for step in range(round(_GRIPPER_SECONDS / timestep)):
            self.step()
            if np.abs(world.data.qvel[robot.finger_dofs]).max() < 0.004 and step * timestep > 0.2:
                break
        for _ in range(round(self._rng.uniform(*_AFTER_GRIPPER) / timestep)):
            self.step()


def drive(simulation: Simulation, seed: int, variation: int | None, sensors: Sensors) -> Recording:
    """Let an operator do the task of a scene seed, and record it.

    Args:
        simulation: reset here.
        seed: of the scene and of the operator.
        variation: the task's variation; drawn from the seed where None.
        sensors: how it is recorded.
    """
    simulation.reset(seed, variation)
    rng = np.random.default_rng((seed, 7))
    world, clock = simulation.world, simulation.clock
    states: list[np.ndarray] = []
    commands: list[bool] = []

    def take() -> None:
        states.append(world.state(states[-1] if states else None))
        commands.append(not world.gripper_closed)

    clock.observe(take, sensors.fps)
    take()
    operator = Operator(simulation, rng)
    waypoints: list[Waypoint] = []
    ends: list[int] = []
    success = False
    while len(ends) < MAX_STEPS and (plan := _left(simulation.plan(), waypoints)) and not success:
        waypoint = plan[0]
        acts = waypoint.gripper_open == world.gripper_closed
        try:
            path = simulation.motion.plan(waypoint.pose, waypoint.ignore_collision)
        except PlanningError:
            break
        arrives = acts or len(plan) == 1 or waypoint.pose.distance(plan[1].pose)[0] < _AIMS
        operator.follow(path, 0.0 if arrives else rng.uniform(*_CORNER_SPEED))
        if arrives:
            operator.settle()
        if acts:
            operator.grip(waypoint.gripper_open)
        if acts and waypoints and _same(waypoints[-1], waypoint):
            waypoints.pop()  # what arrives and acts at once is one keyframe
            ends.pop()
        waypoints.append(waypoint)
        ends.append(len(states) - 1)
        success = simulation.success()
    for _ in range(round(0.3 / clock.timestep)):
        operator.step()
    clock.observe(None)
    success = simulation.success()
    trajectory = np.stack(states).astype(np.float64)
    motion = _recorded(trajectory, np.array(commands), simulation, sensors, rng)
    truth = _truth(trajectory, ends, waypoints, sensors.fps)
    return Recording(motion, truth, waypoints, success, simulation.task.name, seed, int(simulation.task.variation))


def _same(first: Waypoint, second: Waypoint) -> bool:
    """Whether two waypoints ask for the same pose, as far as a person is concerned."""
    distance, angle = first.pose.distance(second.pose)
    return distance < _SAME_METRES and angle < _SAME_RADIANS


def _left(plan: list[Waypoint], done: list[Waypoint]) -> list[Waypoint]:
    """What is left of an expert's plan for somebody who passed by the last waypoint and does not go back for it."""
    while len(plan) > 1 and done and plan[0].gripper_open == done[-1].gripper_open and _same(plan[0], done[-1]):
        plan = plan[1:]
    return plan


def _truth(states: np.ndarray, ends: list[int], waypoints: list[Waypoint], fps: float) -> list[int]:
    """Where the fingers were done, or the hand came closest to the waypoint; the last frame for the last one."""
    reach, found, closed = round(_CLOSEST_WITHIN * fps), list[int](), False
    for place, (end, waypoint) in enumerate(zip(ends, waypoints, strict=True)):
        low = found[-1] + 1 if found else 1
        grips = waypoint.gripper_open == closed
        closed = not waypoint.gripper_open
        if place == len(ends) - 1:
            found.append(len(states) - 1)
        elif grips:
            away = np.abs(states[low : end + 1, schema.GRIPPER] - states[end, schema.GRIPPER]) > _FINGERS_DONE
            found.append(min(end, low + int(np.flatnonzero(away)[-1]) + 1) if away.any() else max(low, end))
        else:
            near = np.arange(max(low, end - 1), max(low, min(end + reach, ends[place + 1])) + 1)
            distance = np.linalg.norm(states[near][:, schema.POSITION] - waypoint.pose.position, axis=1)
            turn = 2 * (1 - np.abs(states[near][:, schema.QUATERNION] @ waypoint.pose.quaternion))
            found.append(int(near[np.argmin(distance**2 + 0.1**2 * turn)]))
    return found


def _recorded(
    states: np.ndarray, commands: np.ndarray, simulation: Simulation, sensors: Sensors, rng: np.random.Generator
) -> Motion:
    """What the sensors made of it; the hand's pose is the forward kinematics of the noisy joints."""
    columns = joint_columns(schema.SIM_STATE_NAMES)
    joints = states[:, columns] + rng.normal(0, sensors.noise, (len(states), len(columns)))
    openings = states[:, schema.GRIPPER] + rng.normal(0, 0.005, len(states))
    if sensors.step:
        joints = np.round(joints / sensors.step) * sensors.step
        openings = np.round(openings * 100) / 100
    kinematics = simulation.world.planner.kinematics
    hands: list[Pose] = [kinematics.forward(one) for one in joints]
    poses = np.array([(*hand.position, *hand.quaternion) for hand in hands])
    poses[:, schema.QUATERNION] = continuous_quaternions(poses[:, schema.QUATERNION])
    return Motion(poses, openings.clip(0, 1), sensors.fps, joints, commands)
