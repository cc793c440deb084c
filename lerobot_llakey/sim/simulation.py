"""One task's scene in motion: the world, the task, the arm's motion, and what perturbs an episode."""

from __future__ import annotations

import functools
from typing import Protocol

import mujoco

from lerobot_llakey.bounds import require_count
from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.arm.panda import HOME_JOINTS
from lerobot_llakey.sim.clock import Clock
from lerobot_llakey.sim.motion import Motion
from lerobot_llakey.sim.scene import base_spec, vary_look
from lerobot_llakey.sim.tasks.base import Task, Waypoint
from lerobot_llakey.sim.world import World

_SETTLE_SECONDS = 0.4


class Perturbation(Protocol):
    """What comes between asking for an action and its execution.

    Attributes:
        struck: whether it has struck in this episode.
        time: simulated seconds at which it struck during the last action, None where it did not.
    """

    struck: bool
    time: float | None

    def execute(self, simulation: Simulation, target: Pose, gripper_open: bool, ignore_collision: bool) -> None:
        """Carry out one keyframe action, perturbed or not.

        Raises:
            PlanningError: as :meth:`lerobot_llakey.sim.motion.Motion.execute` does.
        """


class Simulation:
    """A task's episodes.

    The model is compiled once; :meth:`reset` brings back everything that an episode may change, then lets the task
    place and paint its bodies, so that a seed alone determines the scene.

    Args:
        task: what to build and judge.
        detailed: whether the human's camera sees the robot's detailed meshes; they cost time to load and draw.
    """

    def __init__(self, task: Task, detailed: bool = False) -> None:
        self.task, self.world = task, World(_compiled(type(task), detailed))
        self.clock = Clock(self.world, task.before_step)
        self.motion = Motion(self.world, self.clock)
        self.perturbation: Perturbation | None = None
        self.seed = 0

    def reset(self, seed: int, variation: int | None = None, perturbation: Perturbation | None = None) -> None:
        """Build the episode of a scene seed, at rest.

        Args:
            seed: determines the scene completely.
            variation: the task's variation; drawn from the seed where None.
            perturbation: what comes between the episode's actions and their execution (see
                :func:`lerobot_llakey.sim.perturbations.registry.make_perturbation`), if anything.

        Raises:
            LlakeyError: if the variation is out of range.
        """
        count = self.task.variations
        if variation is not None:
            require_count(f"the variation of {self.task.name}", variation, 0, count - 1)
        world = self.world
        self.seed, self.perturbation = seed, perturbation
        world.reset(seed)
        drawn = int(world.rng.integers(count))
        vary_look(world.model, world.rng)
        world.robot.set_joints(world.data, HOME_JOINTS)
        self.task.reset(world, drawn if variation is None else int(variation))
        mujoco.mj_forward(world.model, world.data)
        self.clock.advance(_SETTLE_SECONDS)

    def plan(self) -> list[Waypoint]:
        """The expert's waypoints that remain from the present state, the next one first; empty when done."""
        return self.task.plan(self.world)

    def success(self) -> bool:
        """Whether the task is done in the present state."""
        return bool(self.task.success(self.world))

    def act(self, target: Pose, gripper_open: bool, ignore_collision: bool) -> None:
        """Carry out one keyframe action, perturbed where the episode has a perturbation.

        Args:
            target: pose of the tool centre point in the base frame.
            gripper_open: state of the gripper afterwards.
            ignore_collision: whether the path may touch things.

        Raises:
            PlanningError: if there is no path; nothing has moved then.
        """
        if self.perturbation is None:
            self.motion.execute(target, gripper_open, ignore_collision)
        else:
            self.perturbation.execute(self, target, gripper_open, ignore_collision)


@functools.cache
def _compiled(task: type[Task], detailed: bool) -> mujoco.MjModel:
    spec = base_spec(detailed)
    task().build(spec)
    return spec.compile()
