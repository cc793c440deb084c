"""The drawers open, each on its own."""

import numpy as np
import pytest

from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks.open_drawer import DRAWERS


@pytest.mark.parametrize("variation", range(3))
@pytest.mark.parametrize("seed", range(2))
def test_expert_opens_the_right_drawer(simulation: Simulation, variation: int, seed: int) -> None:
    world = simulation.world
    simulation.reset(seed, variation)
    assert not simulation.success()
    assert DRAWERS[variation] in simulation.task.description
    steps = list(demonstrate(simulation))
    assert steps[-1].success and len(steps) == 3
    assert [parse(step.waypoint.instruction).template for step in steps] == ["move", "grasp", "pull_open"]
    others = [world.joint(f"{name}_drawer") for name in DRAWERS if name != DRAWERS[variation]]
    assert np.abs(others).max() < 0.02


def test_a_wrong_drawer_is_no_success(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, 2)
    world.set_joint("bottom_drawer", 0.18)
    assert not simulation.success()
    world.set_joint("top_drawer", 0.16)
    assert simulation.success()
