"""The right jar gets closed, whatever goes wrong on the way."""

import numpy as np
import pytest

from lerobot_llakey.geometry import Pose
from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.objects.colours import COLOUR_NAMES
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks.close_jar import CloseJar

STAGES = ["move", "grasp", "raise", "align", "place", "screw_in", "release"]


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(CloseJar())


def act(simulation: Simulation, steps: int) -> None:
    """Let the expert take some actions."""
    for _, step in zip(range(steps), demonstrate(simulation), strict=False):
        assert step.failure == ""


@pytest.mark.parametrize(("seed", "variation"), [(0, 0), (1, 7), (2, 9), (3, 19)])
def test_expert_closes_the_jar_in_seven_actions(simulation: Simulation, seed: int, variation: int) -> None:
    simulation.reset(seed, variation)
    colour = COLOUR_NAMES[variation]
    assert not simulation.success()
    assert f"{colour} jar" in simulation.task.description
    planned = [waypoint.instruction for waypoint in simulation.plan()]
    steps = list(demonstrate(simulation))
    assert steps[-1].success and simulation.plan() == []
    assert [step.waypoint.instruction for step in steps] == planned
    assert [parse(text).template for text in planned] == STAGES
    assert parse(planned[3]).arguments == (f"the {colour} jar",)


def test_scene_is_a_function_of_the_seed_and_leaves_room(simulation: Simulation) -> None:
    world = simulation.world
    for seed in range(30):
        simulation.reset(seed)
        places = np.array([world.pose(body).position[:2] for body in ("jar", "other_jar", "lid")])
        gaps = np.linalg.norm(places - np.roll(places, -1, axis=0), axis=1)
        assert (gaps > (0.13, 0.16, 0.16)).all()
        assert (np.abs(places[:, 1]) < 0.33).all() and (places[:, 0] > 0.3).all() and (places[:, 0] < 0.65).all()
        description = simulation.task.description
        simulation.reset(seed)
        again = np.array([world.pose(body).position[:2] for body in ("jar", "other_jar", "lid")])
        assert np.array_equal(places, again) and description == simulation.task.description


def test_closing_is_success_only_once_released(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(4)
    act(simulation, 6)
    assert world.holds("lid") and not simulation.success()
    assert [parse(waypoint.instruction).template for waypoint in simulation.plan()] == ["release"]


def test_expert_fetches_a_lid_that_was_taken_away(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(5)
    act(simulation, 4)
    home = world.pose("jar").position
    world.place("lid", Pose(np.array([0.5, -0.25 if home[1] > 0 else 0.25, 0.0])))
    simulation.clock.advance(0.3)
    assert simulation.plan()[0].instruction == "move to the top of the lid"
    steps = list(demonstrate(simulation))
    assert steps[-1].success


@pytest.mark.parametrize("direction", [0.0, 2.1, 4.2])
def test_a_lid_set_down_a_centimetre_beside_the_axis_still_seats(simulation: Simulation, direction: float) -> None:
    simulation.reset(6)
    act(simulation, 4)
    waypoint = simulation.plan()[0]
    beside = waypoint.pose.shifted(x=0.009 * np.cos(direction), y=0.009 * np.sin(direction))
    simulation.motion.execute(beside, waypoint.gripper_open, waypoint.ignore_collision)
    steps = list(demonstrate(simulation))
    assert steps[-1].success and [parse(step.waypoint.instruction).template for step in steps][-1] == "release"


def test_the_wrong_jar_can_be_closed_but_is_no_success_and_is_opened_again(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(7)
    task = simulation.task
    assert isinstance(task, CloseJar)
    act(simulation, 3)
    shift = world.pose("other_jar").position - world.pose("jar").position
    for waypoint in task.plan(world):
        pose = waypoint.pose.shifted(x=shift[0], y=shift[1])
        simulation.motion.execute(pose, waypoint.gripper_open, waypoint.ignore_collision)
    assert task.threads[1].turned(world) > np.deg2rad(75)
    assert not task.success(world)
    steps = list(demonstrate(simulation))
    assert steps[-1].success
    assert [parse(step.waypoint.instruction).template for step in steps] == [
        *("move", "grasp", "screw_out"),
        *STAGES[2:],
    ]
