"""The lamp's light, and holders that bulbs stand in."""

import mujoco
import numpy as np
import pytest

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.objects.bulb import GLASS_HEIGHT
from lerobot_llakey.sim.objects.lamp import HOLDER_HEIGHT, SEAT, paint_holder, switch
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks.light_bulb_in import LightBulbIn
from lerobot_llakey.sim.world import World


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(LightBulbIn())


def light_height(world: World) -> float:
    """Metres from the middle of a screwed bulb's glass to the light."""
    mujoco.mj_kinematics(world.model, world.data)
    geom = next(index for index in range(world.model.ngeom) if _is_light(world, index))
    return float(world.data.geom_xpos[geom][2]) - SEAT - GLASS_HEIGHT


def _is_light(world: World, geom: int) -> bool:
    return bool(world.model.geom_bodyid[geom] == world.model.body("lamp_light").id)


def test_the_light_covers_the_glass_when_on_and_is_below_the_table_when_off(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0)
    assert light_height(world) < -0.3
    switch(world, "lamp", True)
    assert 0.0 < light_height(world) < 0.02
    switch(world, "lamp", False)
    assert light_height(world) < -0.3


def test_reset_switches_the_light_off(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0)
    switch(world, "lamp", True)
    simulation.reset(0)
    assert light_height(world) < -0.3


def test_a_holder_keeps_its_bulb_from_sliding(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(1)
    holder = world.pose("holder").position
    world.place("bulb", Pose(holder + (0.012, 0.0, HOLDER_HEIGHT)))
    simulation.clock.advance(0.5)
    assert np.linalg.norm(world.pose("bulb").position[:2] - holder[:2]) < 0.016
    assert world.pose("bulb").position[2] < 0.005


def test_paint_colours_all_of_a_holder(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(1)
    paint_holder(world, "holder", (0.1, 0.2, 0.3))
    colours = [world.model.geom(f"holder_{index}").rgba[:3] for index in range(4)]
    assert np.allclose(colours, (0.1, 0.2, 0.3))
