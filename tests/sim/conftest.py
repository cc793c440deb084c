"""Scenes shared by the simulator's tests: a model takes half a second to compile."""

import pytest

from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.world import World


@pytest.fixture(scope="session")
def drawer_world() -> World:
    return World(make_task("open_drawer"))
