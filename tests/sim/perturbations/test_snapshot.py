"""Snapshots: going back exactly."""

import numpy as np

from lerobot_llakey.sim.perturbations.snapshot import Snapshot
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task


def acted(simulation: Simulation) -> np.ndarray:
    """Everything that moves, after two of the expert's actions."""
    world = simulation.world
    for _ in range(2):
        waypoint = simulation.plan()[0]
        simulation.act(waypoint.pose, waypoint.gripper_open, waypoint.ignore_collision)
    return np.concatenate((world.data.qpos, world.data.qvel, [world.data.time, world.rng.random()]))


def test_what_follows_a_restored_moment_is_the_same_to_the_last_bit() -> None:
    simulation = Simulation(make_task("move_block"))
    world = simulation.world
    simulation.reset(3)
    moment = Snapshot.take(simulation)
    moment.restore(simulation)
    first = acted(simulation)
    simulation.task.description = "something else"
    world.paint("table", (1.0, 0.0, 0.0))
    world.model.geom("table").friction[0] = 0.1
    moment.restore(simulation)
    assert simulation.task.description.startswith("move the")
    assert tuple(world.model.geom("table").rgba[:3]) != (1.0, 0.0, 0.0)
    np.testing.assert_array_equal(acted(simulation), first)
