"""The simulations that a process has compiled."""

from __future__ import annotations

import functools

from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task


@functools.cache
def simulation_of(task: str) -> Simulation:
    """The simulation of a task, built once in each process."""
    return Simulation(make_task(task))
