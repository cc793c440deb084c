"""A seed alone determines a scene."""

import numpy as np
import pytest

from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task


def test_reset_forgets_what_came_before(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(5)
    first = world.data.qpos.copy(), world.model.geom_rgba.copy(), simulation.task.description
    list(demonstrate(simulation))
    simulation.reset(6)
    simulation.reset(5)
    assert np.array_equal(first[0], world.data.qpos)
    assert np.array_equal(first[1], world.model.geom_rgba)
    assert first[2] == simulation.task.description


def test_two_simulations_do_not_share_their_scene(simulation: Simulation) -> None:
    other = Simulation(make_task("open_drawer"))
    simulation.reset(5)
    other.reset(6)
    assert not np.array_equal(other.world.model.body("cabinet").pos, simulation.world.model.body("cabinet").pos)


def test_variation_may_be_asked_for(simulation: Simulation) -> None:
    for variation in range(3):
        simulation.reset(0, variation)
        assert simulation.task.variation == variation
    with pytest.raises(ValueError, match="Expected the variation of open_drawer"):
        simulation.reset(0, 3)
