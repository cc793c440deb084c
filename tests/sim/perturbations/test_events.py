"""Unforeseen events: they strike once, at a seeded moment, and leave a task that the expert can still solve."""

import numpy as np
import pytest

from lerobot_llakey.sim.expert import ExpertStep, demonstrate
from lerobot_llakey.sim.perturbations.events import EVENTS
from lerobot_llakey.sim.perturbations.registry import make_perturbation
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(make_task("move_block"))


def until_struck(simulation: Simulation) -> ExpertStep:
    """Let the expert act until the event has struck, and return the action that it struck."""
    for step in demonstrate(simulation):
        if simulation.perturbation is not None and simulation.perturbation.struck:
            return step
    raise AssertionError("the event never struck")


@pytest.mark.parametrize("kind", EVENTS)
@pytest.mark.parametrize("variation", range(4))
def test_the_expert_recovers_from_every_event(simulation: Simulation, kind: str, variation: int) -> None:
    simulation.reset(20 + variation, variation, make_perturbation(kind, 20 + variation, simulation.task.name))
    *_, last = demonstrate(simulation)
    assert simulation.perturbation is not None and simulation.perturbation.struck and last.success


def test_a_dropped_thing_has_left_the_hand_on_the_way(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, 0, make_perturbation("drop", 0, simulation.task.name))
    step = until_struck(simulation)
    block = world.pose("red_block").position
    assert not world.held_bodies() and world.gripper_closed
    assert world.tool.distance(step.waypoint.pose)[0] < 0.01
    assert np.linalg.norm(block - world.tool.position) > 0.05 and block[2] < 0.06


def test_an_empty_grasp_closes_short_of_the_thing_and_leaves_it_alone(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, 0, make_perturbation("empty_grasp", 0, simulation.task.name))
    before = world.pose("red_block").position
    step = until_struck(simulation)
    assert step.waypoint.instruction == "grasp the red block"
    assert world.gripper_closed and not world.held_bodies()
    np.testing.assert_allclose(world.pose("red_block").position, before, atol=1e-4)
    assert world.tool.position[2] > before[2] + 0.04


def test_a_shift_moves_the_thing_and_a_block_turns_it(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, 0, make_perturbation("shift", 0, simulation.task.name))
    before = world.pose("red_block")
    until_struck(simulation)
    assert 0.01 < before.distance(world.pose("red_block"))[0] < 0.06
    simulation.reset(0, 0, make_perturbation("block", 0, simulation.task.name))
    until_struck(simulation)
    assert before.distance(world.pose("red_block"))[1] > np.deg2rad(20)
    above = world.tool.position - world.pose("red_block").position
    assert world.gripper_closed and np.linalg.norm(above[:2]) < 0.02 and 0.02 < above[2] < 0.1


def test_an_event_strikes_once_and_tells_when(simulation: Simulation) -> None:
    simulation.reset(1, 1, make_perturbation("shift", 1, simulation.task.name))
    times = []
    for _ in demonstrate(simulation):
        assert simulation.perturbation is not None
        times.append(simulation.perturbation.time)
    assert sum(time is not None for time in times) == 1


@pytest.mark.parametrize("kind", ["drop", "block"])
def test_the_same_seed_gives_the_same_event(simulation: Simulation, kind: str) -> None:
    world = simulation.world
    ends = []
    for _ in range(2):
        simulation.reset(5, 2, make_perturbation(kind, 5, simulation.task.name))
        until_struck(simulation)
        ends.append(world.data.qpos.copy())
    np.testing.assert_array_equal(ends[0], ends[1])


def test_moments_differ_between_seeds(simulation: Simulation) -> None:
    struck = set()
    for seed in range(8):
        simulation.reset(seed, 0, make_perturbation("drop", seed, simulation.task.name))
        struck.add(until_struck(simulation).waypoint.instruction)
    assert len(struck) >= 2
