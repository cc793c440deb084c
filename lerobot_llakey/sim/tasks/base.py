"""What a task is: a scene, its variations, an oracle that says when it is done, and an expert."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import mujoco

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.world import World


@dataclass(frozen=True)
class Waypoint:
    """One keyframe action of an expert.

    Attributes:
        pose: tool centre point in the base frame.
        gripper_open: state of the gripper once there.
        ignore_collision: whether the way there may touch things.
        instruction: the basic action in words, rendered by the grammar.
    """

    pose: Pose
    gripper_open: bool
    ignore_collision: bool
    instruction: str


class Task(ABC):
    """A skill in the simulator. Adding a task is adding one file with a subclass.

    Attributes:
        name: as in ``--env.task``.
        variations: number of variations; each fixes colours, targets and the like.
        description: skill instruction of the present episode, in the wording drawn for it.
        variation: variation of the present episode.
        sequence: which of the task's action sequences the present episode needs.
    """

    name: ClassVar[str]
    variations: ClassVar[int]
    sequences: ClassVar[int] = 1
    description: str = ""
    variation: int = 0
    sequence: int = 0

    @abstractmethod
    def build(self, spec: mujoco.MjSpec) -> None:
        """Add the task's bodies to the scene, once; every variation's bodies are there from the start."""

    @abstractmethod
    def reset(self, world: World, variation: int) -> None:
        """Place and paint the bodies of one episode with ``world.rng``; set description, variation and sequence."""

    @abstractmethod
    def success(self, world: World) -> bool:
        """The oracle: whether the task is done in the present state."""

    @abstractmethod
    def plan(self, world: World) -> list[Waypoint]:
        """The expert: the waypoints that remain from the present state, the next one first; empty when done.

        It looks at nothing but the state, so it also says what to do after things went wrong.
        """

    def before_step(self, world: World) -> None:
        """Hook before each time step, for mechanisms that MuJoCo does not model (a thread that bites)."""

    def save(self) -> dict[str, Any]:
        """Everything that the task knows of the present episode."""
        return dict(vars(self))

    def restore(self, saved: dict[str, Any]) -> None:
        """Bring back what :meth:`save` gave."""
        vars(self).clear()
        vars(self).update(saved)
