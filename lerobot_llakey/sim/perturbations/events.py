"""Unforeseen events that strike once an episode, at a seeded moment (paper, Figure 6)."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.arm.planning import PlanningError
from lerobot_llakey.sim.perturbations.snapshot import Snapshot
from lerobot_llakey.sim.simulation import Simulation

Action = tuple[Pose, bool, bool]
"""Target, gripper open, and ignore collision of a keyframe action."""
EVENTS = ("drop", "block", "shift", "empty_grasp")
"""Kinds of unforeseen events: (a), (b), (c) and (d) of Figure 6."""
_SHORTEST_CARRY = 0.05
"""Metres that the hand must travel for what it holds to fall on the way."""
_FALL = (0.25, 0.7)
"""Share of the way after which the thing falls."""
_FALL_SECONDS, _LET_GO_SECONDS = 0.5, 0.3
_DRAG = (0.02, 0.05)
_TURN = np.deg2rad((30.0, 60.0))
_SHORT_OF = (0.045, 0.06)
"""Metres short of the thing at which an empty grasp closes."""
_RETREAT = {"shift": 0.08, "block": 0.06}
"""Metres by which the hand backs off, closed, after a failed grasp."""
_TRIES = 4
"""Draws of an event at one moment before it waits for a later one."""


class Event:
    """One unforeseen event of an episode.

    The event strikes where it fits: ``drop`` during one of the actions that carry something, the others at a grasp.
    What falls, slides or turns does so by contact and gravity alone. A draw after which the expert has no way left that
    the arm can reach (a thing off the table) is taken back and drawn anew, if need be at a later moment.

    Args:
        kind: ``drop`` (the thing in the hand falls on the way), ``block`` (a grasp fails, turns the thing crosswise and
            leaves the closed hand standing over it), ``shift`` (a grasp fails after dragging the thing 2 to 5 cm aside)
            or ``empty_grasp`` (the gripper closes on nothing, short of the thing).
        rng: decides when and how.
    """

    def __init__(self, kind: str, rng: np.random.Generator) -> None:
        self.kind, self.rng, self.struck = kind, rng, False
        acts = {"drop": self._drop, "block": self._block, "shift": self._shift, "empty_grasp": self._empty_grasp}
        self._act = acts[kind]
        self.time: float | None = None
        self._wait: int | None = None

    def execute(self, simulation: Simulation, target: Pose, gripper_open: bool, ignore_collision: bool) -> None:
        """Carry out one keyframe action, with the event if this is its moment."""
        self.time, action = None, (target, gripper_open, ignore_collision)
        if not self.struck and self._fits(simulation, *action):
            before = Snapshot.take(simulation)
            for _ in range(_TRIES):
                if self._rehearse(simulation, before, action):
                    self.struck = True
                    return
        simulation.motion.execute(*action)

    def _fits(self, simulation: Simulation, target: Pose, gripper_open: bool, _: bool) -> bool:
        """Whether this action is one at which the event is to strike."""
        if self.kind != "drop":
            return not gripper_open and not simulation.world.gripper_closed
        if not simulation.world.held_bodies() or not _carries(simulation.world.tool, target):
            return False
        if self._wait is None:
            self._wait = int(self.rng.integers(self._carries_left(simulation)))
        self._wait -= 1
        return self._wait < 0

    @staticmethod
    def _carries_left(simulation: Simulation) -> int:
        """How many of the expert's remaining actions, from the present state, carry the thing somewhere."""
        count, hand = 0, simulation.world.tool
        for waypoint in simulation.plan():
            count += _carries(hand, waypoint.pose)
            hand = waypoint.pose
            if waypoint.gripper_open:
                break
        return max(1, count)

    def _rehearse(self, simulation: Simulation, before: Snapshot, action: Action) -> bool:
        """Try an event unseen; where the task can still be solved, do the same again in front of the cameras."""
        seed = int(self.rng.integers(2**63))
        # From the restored moment both times: the solver's warm start is a part of what decides how things fall.
        before.restore(simulation)
        with simulation.clock.unobserved():
            try:
                self._act(simulation, np.random.default_rng(seed), action)
                good = not simulation.world.held_bodies() and _solvable(simulation)
            except PlanningError:
                good = False
        self.time = None
        before.restore(simulation)
        if good:
            self._act(simulation, np.random.default_rng(seed), action)
        return good

    def _drop(self, simulation: Simulation, rng: np.random.Generator, action: Action) -> None:
        motion, (target, gripper_open, ignore_collision) = simulation.motion, action
        path = motion.plan(target, ignore_collision)
        first, rest = _split(path, rng.uniform(*_FALL))
        motion.follow(first)
        motion.set_gripper(True)
        self.time = float(simulation.world.data.time)
        simulation.clock.advance(_FALL_SECONDS)
        motion.follow(rest)
        motion.set_gripper(gripper_open)
        motion.rest()

    def _empty_grasp(self, simulation: Simulation, rng: np.random.Generator, action: Action) -> None:
        target, _, ignore_collision = action
        simulation.motion.execute(target.advanced(-rng.uniform(*_SHORT_OF)), False, ignore_collision)
        self.time = float(simulation.world.data.time)

    def _shift(self, simulation: Simulation, rng: np.random.Generator, action: Action) -> None:
        target, _, ignore_collision = action
        heading, far = rng.uniform(-np.pi, np.pi), rng.uniform(*_DRAG)
        simulation.motion.execute(target, False, ignore_collision)
        dragged = target.shifted(x=far * float(np.cos(heading)), y=far * float(np.sin(heading)))
        self._lose(simulation, dragged)

    def _block(self, simulation: Simulation, rng: np.random.Generator, action: Action) -> None:
        target, _, ignore_collision = action
        angle = rng.uniform(*_TURN) * rng.choice((-1.0, 1.0))
        simulation.motion.execute(target, False, ignore_collision)
        # Of the two ways to turn, the arm's joints may allow one alone.
        try:
            turned = Pose(target.position, (target.rotation * Rotation.from_euler("z", angle)).as_quat())
            simulation.motion.plan(turned, True)
        except PlanningError:
            turned = Pose(target.position, (target.rotation * Rotation.from_euler("z", -angle)).as_quat())
        self._lose(simulation, turned)

    def _lose(self, simulation: Simulation, target: Pose) -> None:
        """Move what was grasped, let go of it, back off and close the hand."""
        simulation.motion.follow(simulation.motion.plan(target, True))
        simulation.motion.set_gripper(True)
        self.time = float(simulation.world.data.time)
        simulation.clock.advance(_LET_GO_SECONDS)
        simulation.motion.execute(simulation.world.tool.advanced(-_RETREAT[self.kind]), False, True)


def _carries(start: Pose, target: Pose) -> bool:
    """Whether a motion is long enough for a thing to fall on the way, and not the way down on to its target."""
    distance, _ = start.distance(target)
    return bool(distance >= _SHORTEST_CARRY and target.position[2] - start.position[2] > -0.7 * distance)


def _split(path: np.ndarray, share: float) -> tuple[np.ndarray, np.ndarray]:
    """A joint path (N, 7) in two, at a share of its length."""
    lengths = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(path, axis=0)).max(axis=1))))
    at = share * lengths[-1]
    middle = np.array([np.interp(at, lengths, joint) for joint in path.T])
    before = lengths < at
    return np.vstack((path[before], middle)), np.vstack((middle, path[~before]))


def _solvable(simulation: Simulation) -> bool:
    """Whether the expert has something left to do, reaches all of it, and can put the hand around what it grasps."""
    waypoints = simulation.plan()
    joints, planner = simulation.world.robot.joints(simulation.world.data), simulation.world.planner
    grasp = next((waypoint.pose for waypoint in waypoints if not waypoint.gripper_open), None)
    return (
        bool(waypoints)
        and all(
            planner.kinematics.solve_from_many(step.pose, joints, simulation.world.rng) is not None
            for step in waypoints
        )
        and (grasp is None or planner.fits(simulation.world.data, grasp, simulation.world.rng))
    )
