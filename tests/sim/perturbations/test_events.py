"""Unforeseen events: they strike once, at a seeded moment, and leave a task that the expert can still solve."""

import numpy as np
import pytest

from lerobot_llakey.sim.expert import ExpertStep, demonstrate
from lerobot_llakey.sim.perturbations.events import EVENTS
from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.world import World


@pytest.fixture(scope="module")
def world() -> World:
    return World(make_task("move_block"))


def until_struck(world: World) -> ExpertStep:
    """Let the expert act until the event has struck, and return the action that it struck."""
    for step in demonstrate(world):
        if world.disturbance is not None and world.disturbance.struck:
            return step
    raise AssertionError("the event never struck")


@pytest.mark.parametrize("kind", EVENTS)
@pytest.mark.parametrize("variation", range(4))
def test_the_expert_recovers_from_every_event(world: World, kind: str, variation: int) -> None:
    world.reset(20 + variation, variation, kind)
    *_, last = demonstrate(world)
    assert world.disturbance is not None and world.disturbance.struck and last.success


def test_a_dropped_thing_has_left_the_hand_on_the_way(world: World) -> None:
    world.reset(0, 0, "drop")
    step = until_struck(world)
    block = world.pose("red_block").position
    assert not world.held_bodies() and world.gripper_closed
    assert world.tool.distance(step.waypoint.pose)[0] < 0.01
    assert np.linalg.norm(block - world.tool.position) > 0.05 and block[2] < 0.06


def test_an_empty_grasp_closes_short_of_the_thing_and_leaves_it_alone(world: World) -> None:
    world.reset(0, 0, "empty_grasp")
    before = world.pose("red_block").position
    step = until_struck(world)
    assert step.waypoint.instruction == "grasp the red block"
    assert world.gripper_closed and not world.held_bodies()
    np.testing.assert_allclose(world.pose("red_block").position, before, atol=1e-4)
    assert world.tool.position[2] > before[2] + 0.04


def test_a_shift_moves_the_thing_and_a_block_turns_it(world: World) -> None:
    world.reset(0, 0, "shift")
    before = world.pose("red_block")
    until_struck(world)
    assert 0.01 < before.distance(world.pose("red_block"))[0] < 0.06
    world.reset(0, 0, "block")
    until_struck(world)
    assert before.distance(world.pose("red_block"))[1] > np.deg2rad(20)
    above = world.tool.position - world.pose("red_block").position
    assert world.gripper_closed and np.linalg.norm(above[:2]) < 0.02 and 0.02 < above[2] < 0.1


def test_an_event_strikes_once_and_tells_when(world: World) -> None:
    world.reset(1, 1, "shift")
    times = []
    for _ in demonstrate(world):
        assert world.disturbance is not None
        times.append(world.disturbance.time)
    assert sum(time is not None for time in times) == 1


@pytest.mark.parametrize("kind", ["drop", "block"])
def test_the_same_seed_gives_the_same_event(world: World, kind: str) -> None:
    ends = []
    for _ in range(2):
        world.reset(5, 2, kind)
        until_struck(world)
        ends.append(world.data.qpos.copy())
    np.testing.assert_array_equal(ends[0], ends[1])


def test_moments_differ_between_seeds(world: World) -> None:
    struck = set()
    for seed in range(8):
        world.reset(seed, 0, "drop")
        struck.add(until_struck(world).waypoint.instruction)
    assert len(struck) >= 2
