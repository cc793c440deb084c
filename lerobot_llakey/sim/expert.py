"""The scripted demonstrator: it re-plans from the present state before every action."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from lerobot_llakey.sim.arm.planning import PlanningError
from lerobot_llakey.sim.settings import MAX_STEPS
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks.base import Waypoint


@dataclass(frozen=True)
class ExpertStep:
    """One action that the expert took.

    Attributes:
        waypoint: what it went for.
        failure: "" or why the arm did not move: "unreachable" or "collision".
        success: whether the task was done afterwards.
    """

    waypoint: Waypoint
    failure: str
    success: bool


def demonstrate(simulation: Simulation, max_steps: int = MAX_STEPS) -> Iterator[ExpertStep]:
    """Act in a freshly reset simulation until the task is done, yielding after each action.

    It stops early where the expert has nothing left to do or finds no path.
    """
    for _ in range(max_steps):
        waypoints = simulation.plan()
        if not waypoints:
            return
        waypoint = waypoints[0]
        try:
            simulation.act(waypoint.pose, waypoint.gripper_open, waypoint.ignore_collision)
        except PlanningError as error:
            yield ExpertStep(waypoint, error.reason, False)
            return
        success = simulation.success()
        yield ExpertStep(waypoint, "", success)
        if success:
            return
