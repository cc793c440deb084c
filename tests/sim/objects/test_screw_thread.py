"""A thread couples turning and sinking, holds against a pull, and lets go when turned back; tried on a jar."""

import numpy as np
import pytest

from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.objects.screw_thread import ScrewThread
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks.close_jar import CloseJar
from lerobot_llakey.sim.world import World


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(CloseJar())


def act_until(simulation: Simulation, words: str) -> None:
    """Let the expert act up to and including the action whose instruction holds some words."""
    for step in demonstrate(simulation):
        if words in step.waypoint.instruction:
            return
    raise AssertionError(f"the expert never came to {words!r}")


def lid_height(world: World) -> float:
    return float(world.pose("lid").position[2])


def thread_of(simulation: Simulation) -> ScrewThread:
    task = simulation.task
    assert isinstance(task, CloseJar)
    return task.thread


def test_a_seated_part_that_was_not_turned_lifts_off(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(2)
    act_until(simulation, "place")
    assert thread_of(simulation).seated(world) and not thread_of(simulation).engaged(world)
    before = lid_height(world)
    simulation.motion.execute(world.tool.shifted(z=0.05), False, True)
    assert lid_height(world) - before == pytest.approx(0.05, abs=0.006)


def test_it_sinks_along_its_helix(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(2)
    thread = thread_of(simulation)
    act_until(simulation, "place")
    entry = lid_height(world)
    heights, turns = [], []
    waypoint = simulation.plan()[0]
    simulation.clock.observe(lambda: (heights.append(lid_height(world)), turns.append(thread.turned(world))), fps=25)
    simulation.motion.execute(waypoint.pose, waypoint.gripper_open, waypoint.ignore_collision)
    simulation.clock.observe(None)
    assert max(turns) > np.deg2rad(90)
    bitten = np.array(turns) > 0.05
    expected = entry - thread.travel / thread.angle * np.array(turns)
    assert np.abs(np.array(heights) - expected)[bitten].max() < 0.002


def test_it_holds_against_a_pull_and_comes_free_when_turned_back(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(2)
    thread = thread_of(simulation)
    before_turn = None
    for step in demonstrate(simulation):
        if "place" in step.waypoint.instruction:
            before_turn = world.tool
        if "screw" in step.waypoint.instruction:
            break
    assert before_turn is not None
    after_turn, low = world.tool, lid_height(world)
    simulation.motion.execute(after_turn.shifted(z=0.05), False, True)
    assert lid_height(world) - low < 0.002 and thread.turned(world) > np.deg2rad(75)

    simulation.reset(2)
    act_until(simulation, "screw")
    simulation.motion.execute(before_turn, False, True)
    assert not thread.engaged(world)
    simulation.motion.execute(before_turn.shifted(z=0.05), False, True)
    assert lid_height(world) - low > 0.04


def test_a_part_can_begin_screwed_in(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(3)
    thread = thread_of(simulation)
    thread.start_in(world)
    simulation.clock.advance(0.5)
    assert thread.engaged(world) and thread.turned(world) == pytest.approx(thread.angle, abs=0.05)
    below = world.data.body("jar_nut").xpos - world.data.body("lid").xpos
    assert np.abs(below).max() < 0.002
