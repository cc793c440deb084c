"""Snapshots: going back exactly."""

import numpy as np

from lerobot_llakey.sim.perturbations.snapshot import Snapshot
from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.world import World


def acted(world: World) -> np.ndarray:
    """Everything that moves, after two of the expert's actions."""
    for _ in range(2):
        waypoint = world.task.plan(world)[0]
        world.act(waypoint.pose, waypoint.gripper_open, waypoint.ignore_collision)
    return np.concatenate((world.data.qpos, world.data.qvel, [world.data.time, world.rng.random()]))


def test_what_follows_a_restored_moment_is_the_same_to_the_last_bit() -> None:
    world = World(make_task("move_block"))
    world.reset(3)
    moment = Snapshot.take(world)
    moment.restore(world)
    first = acted(world)
    world.task.description = "something else"
    world.paint("table", (1.0, 0.0, 0.0))
    moment.restore(world)
    assert world.task.description.startswith("move the")
    assert tuple(world.model.geom("table").rgba[:3]) != (1.0, 0.0, 0.0)
    np.testing.assert_array_equal(acted(world), first)
