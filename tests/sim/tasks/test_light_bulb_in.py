"""The right bulb lights the lamp, whatever goes wrong on the way."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.objects.colours import COLOUR_NAMES, COLOURS
from lerobot_llakey.sim.tasks.light_bulb_in import LightBulbIn
from lerobot_llakey.sim.world import World

STAGES = ["move", "grasp", "raise", "align", "place", "screw_in", "release"]


@pytest.fixture(scope="module")
def world() -> World:
    return World(LightBulbIn())


def act(world: World, steps: int) -> None:
    """Let the expert take some actions."""
    for _, step in zip(range(steps), demonstrate(world), strict=False):
        assert step.failure == ""


def templates(world: World) -> list[str]:
    """Let the expert finish, and tell what it did."""
    steps = list(demonstrate(world))
    assert steps[-1].success and world.task.plan(world) == []
    return [parse(step.waypoint.instruction).template for step in steps]


def lit(world: World) -> bool:
    return world.joint("lamp_light") > 0.2


def screw_in_the_other(world: World) -> None:
    """As the expert would, but with the other bulb."""
    shift = world.pose("other_bulb").position - world.pose("bulb").position
    for index, waypoint in enumerate(world.task.plan(world)):
        pose = waypoint.pose.shifted(*shift[:2]) if index < 3 else waypoint.pose
        world.motion.execute(pose, waypoint.gripper_open, waypoint.ignore_collision)


@pytest.mark.parametrize(("seed", "variation"), [(0, 0), (1, 7), (2, 9), (3, 19)])
def test_expert_lights_the_lamp_in_seven_actions(world: World, seed: int, variation: int) -> None:
    world.reset(seed, variation)
    colour = COLOUR_NAMES[variation]
    assert not world.task.success(world) and not lit(world)
    assert colour in world.task.description
    assert np.allclose(world.model.geom("bulb_collar").rgba[:3], COLOURS[colour])
    planned = [waypoint.instruction for waypoint in world.task.plan(world)]
    assert planned[0] == f"move to the top of the {colour} light bulb"
    steps = list(demonstrate(world))
    assert steps[-1].success and world.task.plan(world) == [] and lit(world)
    assert [step.waypoint.instruction for step in steps] == planned
    assert [parse(text).template for text in planned] == STAGES


def test_scene_is_a_function_of_the_seed_and_leaves_room(world: World) -> None:
    for seed in range(20):
        world.reset(seed)
        places = np.array([world.pose(body).position[:2] for body in ("lamp", "holder", "other_holder")])
        assert (np.linalg.norm(places - np.roll(places, -1, axis=0), axis=1) > 0.15).all()
        for bulb, holder in (("bulb", 1), ("other_bulb", 2)):
            assert np.linalg.norm(world.pose(bulb).position[:2] - places[holder]) < 0.004
        description = world.task.description
        world.reset(seed)
        again = np.array([world.pose(body).position[:2] for body in ("lamp", "holder", "other_holder")])
        assert np.array_equal(places, again) and description == world.task.description


def test_the_lamp_lights_up_once_screwed_and_success_needs_a_release(world: World) -> None:
    world.reset(4)
    act(world, 5)
    assert not lit(world)
    act(world, 1)
    assert lit(world) and world.holds("bulb") and not world.task.success(world)
    assert [parse(waypoint.instruction).template for waypoint in world.task.plan(world)] == ["release"]


def test_expert_fetches_a_bulb_that_fell_on_its_side(world: World) -> None:
    world.reset(5)
    act(world, 4)
    lamp = world.pose("lamp").position
    spot = np.array((0.5, -0.25 if lamp[1] > 0 else 0.25, 0.06))
    world.place("bulb", Pose(spot, Rotation.from_euler("y", 1.4).as_quat()))
    world.advance(1.5)
    assert parse(world.task.plan(world)[0].instruction).template == "move"
    assert templates(world) == STAGES


def test_a_half_screwed_bulb_is_screwed_on(world: World) -> None:
    world.reset(6)
    act(world, 5)
    screw = world.task.plan(world)[0]
    half = Pose(screw.pose.position, top_down(np.deg2rad(15)))
    world.motion.execute(half, False, True)
    world.motion.execute(world.tool, True, True)
    assert not world.task.success(world) and not lit(world)
    assert templates(world) == ["move", "grasp", "screw_in", "release"]


def test_a_bulb_that_leans_in_the_hand_is_set_upright(world: World) -> None:
    world.reset(7)
    act(world, 2)
    lean = Rotation.from_rotvec(world.tool.rotation.apply((0.0, np.deg2rad(15), 0.0)))
    world.motion.execute(Pose(world.tool.shifted(z=0.06).position, (lean * world.tool.rotation).as_quat()), False, True)
    assert templates(world)[-3:] == ["place", "screw_in", "release"]


def test_the_wrong_bulb_in_the_hand_is_let_go(world: World) -> None:
    world.reset(8)
    task = world.task
    assert isinstance(task, LightBulbIn)
    grasp = Pose(world.pose("other_bulb").position, top_down(np.deg2rad(55))).shifted(z=0.06)
    world.motion.execute(grasp.shifted(z=0.1), True, True)
    world.motion.execute(grasp, False, True)
    assert world.holds("other_bulb")
    assert task.plan(world)[0].instruction == f"release the {task.colours[1]} light bulb"
    assert templates(world) == ["release", *STAGES]


def test_the_wrong_bulb_lights_the_lamp_but_is_no_success_and_goes_back_to_its_holder(world: World) -> None:
    world.reset(9)
    screw_in_the_other(world)
    assert lit(world) and not world.task.success(world)
    assert templates(world) == ["move", "grasp", "screw_out", "raise", "move", "release", *STAGES]
    assert np.linalg.norm((world.pose("other_bulb").position - world.pose("other_holder").position)[:2]) < 0.02


@pytest.mark.parametrize("kind", ["drop", "block", "shift", "empty_grasp"])
def test_expert_recovers(world: World, kind: str) -> None:
    world.reset(10, disturbance=kind)
    assert list(demonstrate(world))[-1].success
    assert world.disturbance is not None and world.disturbance.struck
