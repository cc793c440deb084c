"""The scenes that a process has compiled."""

from __future__ import annotations

import functools

from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.world import World


@functools.cache
def world_of(task: str) -> World:
    """The scene of a task, built once in each process."""
    return World(make_task(task))
