"""Blocks go to their targets, each by the only way there is."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.tasks.base import Waypoint

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
def simulation() -> Simulation:
    return Simulation(make_task("move_block"))


def put(simulation: Simulation, block: str, position: np.ndarray, rotation: Rotation | None = None) -> None:
    world = simulation.world
    world.place(f"{block}_block", Pose(position, (rotation or Rotation.identity()).as_quat()))
    simulation.clock.advance(0.3)


def follow(simulation: Simulation, waypoint: Waypoint) -> None:
    simulation.motion.execute(waypoint.pose, waypoint.gripper_open, waypoint.ignore_collision)


def act(simulation: Simulation, pose: Pose, gripper_open: bool) -> None:
    simulation.motion.execute(pose, gripper_open, True)


def take_from_above(simulation: Simulation, block: str) -> None:
    world = simulation.world
    grasp = Pose(world.pose(f"{block}_block").position, top_down(0.0)).shifted(z=0.008)
    act(simulation, grasp.shifted(z=0.12), True)
    act(simulation, grasp, False)


@pytest.mark.parametrize("variation", range(4))
@pytest.mark.parametrize("seed", range(3))
def test_expert_brings_the_block_to_its_target(simulation: Simulation, variation: int, seed: int) -> None:
    world = simulation.world
    simulation.reset(seed, variation)
    assert not simulation.success()
    assert simulation.task.sequence == (0, 1, 2, 2)[variation]
    colours = (("red", "purple"), ("red", "orange"), ("yellow", "blue"), ("yellow", "green"))[variation]
    assert simulation.task.description == "move the {} block to the {} target".format(*colours)
    other = "yellow" if colours[0] == "red" else "red"
    bystander = world.pose(f"{other}_block").position
    steps = list(demonstrate(simulation))
    assert steps[-1].success and not simulation.plan()
    assert [parse(step.waypoint.instruction).template for step in steps] == TEMPLATES[variation]
    block, target = world.pose(f"{colours[0]}_block"), world.pose(f"{colours[1]}_target")
    assert np.linalg.norm(block.position[:2] - target.position[:2]) < 0.005
    assert np.linalg.norm(world.pose(f"{other}_block").position - bystander) < 0.005


def test_another_target_is_no_success(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, BLUE)
    for target, done in (("green", False), ("purple", False), ("orange", False), ("blue", True)):
        put(simulation, "yellow", world.pose(f"{target}_target").position + (0, 0, CENTRE + 0.004))
        assert simulation.success() == done, target


def test_another_block_is_no_success(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, BLUE)
    put(simulation, "red", world.pose("blue_target").position + (0, 0, CENTRE + 0.004))
    assert not simulation.success()


def test_a_block_in_the_hand_or_on_the_rim_is_no_success(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, PURPLE)
    steps = demonstrate(simulation)
    while parse(next(steps).waypoint.instruction).template != "insert":
        assert not simulation.success()
    assert world.holds("red_block") and not simulation.success()
    frame = world.pose("purple_target")
    simulation.reset(0, PURPLE)
    put(simulation, "red", frame.apply((0.03, 0.0, 0.04)), frame.rotation)
    assert not simulation.success()


@pytest.mark.parametrize("seed", range(2))
def test_the_shelter_holds_a_block_that_is_not_pulled_out(simulation: Simulation, seed: int) -> None:
    world = simulation.world
    simulation.reset(seed, BLUE)
    for waypoint in simulation.plan()[:2]:
        follow(simulation, waypoint)
    assert world.holds("yellow_block")
    act(simulation, world.tool.shifted(z=0.12), False)
    assert world.pose("yellow_block").position[2] < 0.04


@pytest.mark.parametrize("short", [0.0, 0.015])
def test_a_block_let_fall_on_the_orange_target_is_no_success(simulation: Simulation, short: float) -> None:
    world = simulation.world
    simulation.reset(1, ORANGE)
    put(simulation, "red", world.pose("red_block").position)
    take_from_above(simulation, "red")
    assert world.holds("red_block")
    act(simulation, world.tool.shifted(z=0.12), False)
    goal = Pose(world.pose("orange_target").position + (-short, 0, CENTRE + 0.01), top_down(0.0))
    act(simulation, goal.shifted(z=0.1), False)
    act(simulation, goal, False)
    act(simulation, world.tool, True)
    assert not simulation.success()


@pytest.mark.parametrize(
    ("variation", "forward", "inwards"),
    [(PURPLE, -0.12, 0.05), (ORANGE, -0.12, 0.05), (ORANGE, -0.035, 0.0), (ORANGE, 0.02, 0.11)],
)
def test_expert_finds_a_displaced_block(simulation: Simulation, variation: int, forward: float, inwards: float) -> None:
    """In front of the orange target, short of it, and beside it, where its wall is in the way."""
    world = simulation.world
    simulation.reset(5, variation)
    target = world.pose("orange_target").position
    position = target + (forward, -np.sign(target[1]) * inwards, CENTRE)
    put(simulation, "red", position, Rotation.from_euler("z", 0.3 if inwards else 0.0))
    assert not simulation.success()
    steps = list(demonstrate(simulation))
    assert steps[-1].success
    around = "move to the front of the orange target" in [step.waypoint.instruction for step in steps]
    assert around == (inwards > 0.1)


def test_expert_takes_a_block_pushed_deep_into_the_shelter(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(2, GREEN)
    put(simulation, "yellow", world.pose("shelter").position + (0.018, 0.0, CENTRE))
    steps = list(demonstrate(simulation))
    assert steps[-1].success
    assert "pull the yellow block out" in [step.waypoint.instruction for step in steps]


def test_expert_does_not_pull_what_is_out_already(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(2, GREEN)
    put(simulation, "yellow", world.pose("shelter").position + (-0.11, 0.0, CENTRE))
    steps = list(demonstrate(simulation))
    assert steps[-1].success
    assert [parse(step.waypoint.instruction).template for step in steps] == ["move", "grasp", *CARRY]
    assert steps[0].waypoint.instruction == "move to the top of the yellow block"


def test_expert_takes_up_a_block_that_it_lost_on_the_way(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(3, PURPLE)
    for _ in range(4):
        follow(simulation, simulation.plan()[0])
    assert world.holds("red_block")
    act(simulation, world.tool.shifted(x=0.05, z=-0.05), True)
    assert not simulation.success()
    assert parse(simulation.plan()[0].instruction).template in ("move", "grasp")
    assert list(demonstrate(simulation))[-1].success


def test_the_wrong_block_is_let_go(simulation: Simulation) -> None:
    simulation.reset(0, BLUE)
    take_from_above(simulation, "red")
    assert simulation.plan()[0].instruction == "release the red block"
    assert list(demonstrate(simulation))[-1].success


def test_a_tumbled_block_is_grasped_along_its_sides(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, PURPLE)
    put(simulation, "red", world.pose("red_block").position, Rotation.from_euler("ZY", (0.3, np.pi / 2)))
    above = simulation.plan()[0].pose
    assert above.distance(Pose(above.position, top_down(0.3)))[1] < 0.02
