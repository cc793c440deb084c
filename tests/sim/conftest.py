"""Scenes shared by the simulator's tests: a model takes half a second to compile."""

import pytest

from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task


@pytest.fixture(scope="session")
def simulation() -> Simulation:
    return Simulation(make_task("open_drawer"))
