"""The right jar gets closed, whatever goes wrong on the way."""

import numpy as np
import pytest

from lerobot_llakey.geometry import Pose
from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.objects.colours import COLOUR_NAMES
from lerobot_llakey.sim.tasks.close_jar import CloseJar
from lerobot_llakey.sim.world import World

STAGES = ["move", "grasp", "raise", "align", "place", "screw_in", "release"]


@pytest.fixture(scope="module")
def world() -> World:
    return World(CloseJar())


def act(world: World, steps: int) -> None:
    """Let the expert take some actions."""
    for _, step in zip(range(steps), demonstrate(world), strict=False):
        assert step.failure == ""


@pytest.mark.parametrize(("seed", "variation"), [(0, 0), (1, 7), (2, 9), (3, 19)])
def test_expert_closes_the_jar_in_seven_actions(world: World, seed: int, variation: int) -> None:
    world.reset(seed, variation)
    colour = COLOUR_NAMES[variation]
    assert not world.task.success(world)
    assert f"{colour} jar" in world.task.description
    planned = [waypoint.instruction for waypoint in world.task.plan(world)]
    steps = list(demonstrate(world))
    assert steps[-1].success and world.task.plan(world) == []
    assert [step.waypoint.instruction for step in steps] == planned
    assert [parse(text).template for text in planned] == STAGES
    assert parse(planned[3]).arguments == (f"the {colour} jar",)


def test_scene_is_a_function_of_the_seed_and_leaves_room(world: World) -> None:
    for seed in range(30):
        world.reset(seed)
        places = np.array([world.pose(body).position[:2] for body in ("jar", "other_jar", "lid")])
        gaps = np.linalg.norm(places - np.roll(places, -1, axis=0), axis=1)
        assert (gaps > (0.13, 0.16, 0.16)).all()
        assert (np.abs(places[:, 1]) < 0.33).all() and (places[:, 0] > 0.3).all() and (places[:, 0] < 0.65).all()
        description = world.task.description
        world.reset(seed)
        again = np.array([world.pose(body).position[:2] for body in ("jar", "other_jar", "lid")])
        assert np.array_equal(places, again) and description == world.task.description


def test_closing_is_success_only_once_released(world: World) -> None:
    world.reset(4)
    act(world, 6)
    assert world.holds("lid") and not world.task.success(world)
    assert [parse(waypoint.instruction).template for waypoint in world.task.plan(world)] == ["release"]


def test_expert_fetches_a_lid_that_was_taken_away(world: World) -> None:
    world.reset(5)
    act(world, 4)
    home = world.pose("jar").position
    world.place("lid", Pose(np.array([0.5, -0.25 if home[1] > 0 else 0.25, 0.0])))
    world.advance(0.3)
    assert world.task.plan(world)[0].instruction == "move to the top of the lid"
    steps = list(demonstrate(world))
    assert steps[-1].success


@pytest.mark.parametrize("direction", [0.0, 2.1, 4.2])
def test_a_lid_set_down_a_centimetre_beside_the_axis_still_seats(world: World, direction: float) -> None:
    world.reset(6)
    act(world, 4)
    waypoint = world.task.plan(world)[0]
    beside = waypoint.pose.shifted(x=0.009 * np.cos(direction), y=0.009 * np.sin(direction))
    world.motion.execute(beside, waypoint.gripper_open, waypoint.ignore_collision)
    steps = list(demonstrate(world))
    assert steps[-1].success and [parse(step.waypoint.instruction).template for step in steps][-1] == "release"


def test_the_wrong_jar_can_be_closed_but_is_no_success_and_is_opened_again(world: World) -> None:
    world.reset(7)
    task = world.task
    assert isinstance(task, CloseJar)
    act(world, 3)
    shift = world.pose("other_jar").position - world.pose("jar").position
    for waypoint in task.plan(world):
        pose = waypoint.pose.shifted(x=shift[0], y=shift[1])
        world.motion.execute(pose, waypoint.gripper_open, waypoint.ignore_collision)
    assert task.threads[1].turned(world) > np.deg2rad(75)
    assert not task.success(world)
    steps = list(demonstrate(world))
    assert steps[-1].success
    assert [parse(step.waypoint.instruction).template for step in steps] == [
        *("move", "grasp", "screw_out"),
        *STAGES[2:],
    ]
