"""A thread couples turning and sinking, holds against a pull, and lets go when turned back; tried on a jar."""

import numpy as np
import pytest

from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.objects.screw_thread import Thread
from lerobot_llakey.sim.tasks.close_jar import CloseJar
from lerobot_llakey.sim.world import World


@pytest.fixture(scope="module")
def world() -> World:
    return World(CloseJar())


def act_until(world: World, words: str) -> None:
    """Let the expert act up to and including the action whose instruction holds some words."""
    for step in demonstrate(world):
        if words in step.waypoint.instruction:
            return
    raise AssertionError(f"the expert never came to {words!r}")


def lid_height(world: World) -> float:
    return float(world.pose("lid").position[2])


def thread_of(world: World) -> Thread:
    task = world.task
    assert isinstance(task, CloseJar)
    return task.thread


def test_a_seated_part_that_was_not_turned_lifts_off(world: World) -> None:
    world.reset(2)
    act_until(world, "place")
    assert thread_of(world).seated(world) and not thread_of(world).engaged(world)
    before = lid_height(world)
    world.motion.execute(world.tool.shifted(z=0.05), False, True)
    assert lid_height(world) - before == pytest.approx(0.05, abs=0.006)


def test_it_sinks_along_its_helix(world: World) -> None:
    world.reset(2)
    thread = thread_of(world)
    act_until(world, "place")
    entry = lid_height(world)
    heights, turns = [], []
    waypoint = world.task.plan(world)[0]
    world.observe(lambda: (heights.append(lid_height(world)), turns.append(thread.turned(world))), fps=25)
    world.motion.execute(waypoint.pose, waypoint.gripper_open, waypoint.ignore_collision)
    world.observe(None)
    assert max(turns) > np.deg2rad(90)
    bitten = np.array(turns) > 0.05
    expected = entry - thread.travel / thread.angle * np.array(turns)
    assert np.abs(np.array(heights) - expected)[bitten].max() < 0.002


def test_it_holds_against_a_pull_and_comes_free_when_turned_back(world: World) -> None:
    world.reset(2)
    thread = thread_of(world)
    before_turn = None
    for step in demonstrate(world):
        if "place" in step.waypoint.instruction:
            before_turn = world.tool
        if "screw" in step.waypoint.instruction:
            break
    assert before_turn is not None
    after_turn, low = world.tool, lid_height(world)
    world.motion.execute(after_turn.shifted(z=0.05), False, True)
    assert lid_height(world) - low < 0.002 and thread.turned(world) > np.deg2rad(75)

    world.reset(2)
    act_until(world, "screw")
    world.motion.execute(before_turn, False, True)
    assert not thread.engaged(world)
    world.motion.execute(before_turn.shifted(z=0.05), False, True)
    assert lid_height(world) - low > 0.04


def test_a_part_can_begin_screwed_in(world: World) -> None:
    world.reset(3)
    thread = thread_of(world)
    thread.start_in(world)
    world.advance(0.5)
    assert thread.engaged(world) and thread.turned(world) == pytest.approx(thread.angle, abs=0.05)
    below = world.data.body("jar_nut").xpos - world.data.body("lid").xpos
    assert np.abs(below).max() < 0.002
