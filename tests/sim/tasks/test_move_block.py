"""Blocks go to their targets, each by the only way there is."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.tasks.base import Waypoint
from lerobot_llakey.sim.world import World

PURPLE, ORANGE, BLUE, GREEN = range(4)
CARRY = ["raise", "move", "place", "release"]
TEMPLATES = (
    ["move", "grasp", "raise", "align", "insert", "release"],
    ["move", "grasp", "slide", "release"],
    ["move", "grasp", "pull_out", *CARRY],
    ["move", "grasp", "pull_out", *CARRY],
)
CENTRE = 0.02
"""Height of the centre of a block that stands on the table."""


@pytest.fixture(scope="module")
def world() -> World:
    return World(make_task("move_block"))


def put(world: World, block: str, spot: np.ndarray, rotation: Rotation | None = None) -> None:
    world.place(f"{block}_block", Pose(spot, (rotation or Rotation.identity()).as_quat()))
    world.advance(0.3)


def follow(world: World, waypoint: Waypoint) -> None:
    world.motion.execute(waypoint.pose, waypoint.gripper_open, waypoint.ignore_collision)


def act(world: World, pose: Pose, gripper_open: bool) -> None:
    world.motion.execute(pose, gripper_open, True)


def take_from_above(world: World, block: str) -> None:
    grasp = Pose(world.pose(f"{block}_block").position, top_down(0.0)).shifted(z=0.008)
    act(world, grasp.shifted(z=0.12), True)
    act(world, grasp, False)


@pytest.mark.parametrize("variation", range(4))
@pytest.mark.parametrize("seed", range(3))
def test_expert_brings_the_block_to_its_target(world: World, variation: int, seed: int) -> None:
    world.reset(seed, variation)
    assert not world.task.success(world)
    assert world.task.sequence == (0, 1, 2, 2)[variation]
    colours = (("red", "purple"), ("red", "orange"), ("yellow", "blue"), ("yellow", "green"))[variation]
    assert world.task.description == "move the {} block to the {} target".format(*colours)
    other = "yellow" if colours[0] == "red" else "red"
    bystander = world.pose(f"{other}_block").position
    steps = list(demonstrate(world))
    assert steps[-1].success and not world.task.plan(world)
    assert [parse(step.waypoint.instruction).template for step in steps] == TEMPLATES[variation]
    block, target = world.pose(f"{colours[0]}_block"), world.pose(f"{colours[1]}_target")
    assert np.linalg.norm(block.position[:2] - target.position[:2]) < 0.005
    assert np.linalg.norm(world.pose(f"{other}_block").position - bystander) < 0.005


def test_another_target_is_no_success(world: World) -> None:
    world.reset(0, BLUE)
    for target, done in (("green", False), ("purple", False), ("orange", False), ("blue", True)):
        put(world, "yellow", world.pose(f"{target}_target").position + (0, 0, CENTRE + 0.004))
        assert world.task.success(world) == done, target


def test_another_block_is_no_success(world: World) -> None:
    world.reset(0, BLUE)
    put(world, "red", world.pose("blue_target").position + (0, 0, CENTRE + 0.004))
    assert not world.task.success(world)


def test_a_block_in_the_hand_or_on_the_rim_is_no_success(world: World) -> None:
    world.reset(0, PURPLE)
    steps = demonstrate(world)
    while parse(next(steps).waypoint.instruction).template != "insert":
        assert not world.task.success(world)
    assert world.holds("red_block") and not world.task.success(world)
    frame = world.pose("purple_target")
    world.reset(0, PURPLE)
    put(world, "red", frame.apply((0.03, 0.0, 0.04)), frame.rotation)
    assert not world.task.success(world)


@pytest.mark.parametrize("seed", range(2))
def test_the_shelter_holds_a_block_that_is_not_pulled_out(world: World, seed: int) -> None:
    world.reset(seed, BLUE)
    for waypoint in world.task.plan(world)[:2]:
        follow(world, waypoint)
    assert world.holds("yellow_block")
    act(world, world.tool.shifted(z=0.12), False)
    assert world.pose("yellow_block").position[2] < 0.04


@pytest.mark.parametrize("short", [0.0, 0.015])
def test_a_block_let_fall_on_the_orange_target_is_no_success(world: World, short: float) -> None:
    world.reset(1, ORANGE)
    put(world, "red", world.pose("red_block").position)
    take_from_above(world, "red")
    assert world.holds("red_block")
    act(world, world.tool.shifted(z=0.12), False)
    goal = Pose(world.pose("orange_target").position + (-short, 0, CENTRE + 0.01), top_down(0.0))
    act(world, goal.shifted(z=0.1), False)
    act(world, goal, False)
    act(world, world.tool, True)
    assert not world.task.success(world)


@pytest.mark.parametrize(
    ("variation", "forward", "inwards"),
    [(PURPLE, -0.12, 0.05), (ORANGE, -0.12, 0.05), (ORANGE, -0.035, 0.0), (ORANGE, 0.02, 0.11)],
)
def test_expert_finds_a_displaced_block(world: World, variation: int, forward: float, inwards: float) -> None:
    """In front of the orange target, short of it, and beside it, where its wall is in the way."""
    world.reset(5, variation)
    target = world.pose("orange_target").position
    spot = target + (forward, -np.sign(target[1]) * inwards, CENTRE)
    put(world, "red", spot, Rotation.from_euler("z", 0.3 if inwards else 0.0))
    assert not world.task.success(world)
    steps = list(demonstrate(world))
    assert steps[-1].success
    around = "move to the front of the orange target" in [step.waypoint.instruction for step in steps]
    assert around == (inwards > 0.1)


def test_expert_takes_a_block_pushed_deep_into_the_shelter(world: World) -> None:
    world.reset(2, GREEN)
    put(world, "yellow", world.pose("shelter").position + (0.018, 0.0, CENTRE))
    steps = list(demonstrate(world))
    assert steps[-1].success
    assert "pull the yellow block out" in [step.waypoint.instruction for step in steps]


def test_expert_does_not_pull_what_is_out_already(world: World) -> None:
    world.reset(2, GREEN)
    put(world, "yellow", world.pose("shelter").position + (-0.11, 0.0, CENTRE))
    steps = list(demonstrate(world))
    assert steps[-1].success
    assert [parse(step.waypoint.instruction).template for step in steps] == ["move", "grasp", *CARRY]
    assert steps[0].waypoint.instruction == "move to the top of the yellow block"


def test_expert_takes_up_a_block_that_it_lost_on_the_way(world: World) -> None:
    world.reset(3, PURPLE)
    for _ in range(4):
        follow(world, world.task.plan(world)[0])
    assert world.holds("red_block")
    act(world, world.tool.shifted(x=0.05, z=-0.05), True)
    assert not world.task.success(world)
    assert parse(world.task.plan(world)[0].instruction).template in ("move", "grasp")
    assert list(demonstrate(world))[-1].success


def test_the_wrong_block_is_let_go(world: World) -> None:
    world.reset(0, BLUE)
    take_from_above(world, "red")
    assert world.task.plan(world)[0].instruction == "release the red block"
    assert list(demonstrate(world))[-1].success


def test_a_tumbled_block_is_grasped_along_its_sides(world: World) -> None:
    world.reset(0, PURPLE)
    put(world, "red", world.pose("red_block").position, Rotation.from_euler("ZY", (0.3, np.pi / 2)))
    above = world.task.plan(world)[0].pose
    assert above.distance(Pose(above.position, top_down(0.3)))[1] < 0.02
