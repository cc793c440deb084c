"""Cups go to their targets, each by the way its place and pose ask for."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose
from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.objects.cup import CUP_HEIGHT, CUP_RADIUS
from lerobot_llakey.sim.tasks.move_cup import CLAMP, PULL_OUT, SLIDE, TURN, MoveCup
from lerobot_llakey.sim.world import World

CARRY = ["raise", "move", "place", "release"]
TURNED = ["raise", "rotate", "move", "place", "release"]
TEMPLATES = {
    CLAMP: ["move", "grasp", *CARRY],
    SLIDE: ["move", "grasp", "slide", "release"],
    TURN: ["move", "grasp", *TURNED],
    PULL_OUT: ["move", "grasp", "pull_out", *TURNED],
}
UPSIDE_DOWN = Rotation.from_euler("x", np.pi)
LYING = Rotation.from_euler("x", np.pi / 2)


@pytest.fixture(scope="module")
def world() -> World:
    return World(MoveCup())


def put(world: World, cup: str, spot: np.ndarray, rotation: Rotation | None = None) -> None:
    world.place(cup, Pose(spot, (rotation or Rotation.identity()).as_quat()))
    world.advance(0.5)


def follow(world: World, count: int) -> None:
    for _ in range(count):
        waypoint = world.task.plan(world)[0]
        world.motion.execute(waypoint.pose, waypoint.gripper_open, waypoint.ignore_collision)


def finish(world: World) -> list[str]:
    """The templates of the instructions that the expert followed to the end."""
    steps = list(demonstrate(world))
    assert steps[-1].success and not world.task.plan(world)
    return [parse(step.waypoint.instruction).template for step in steps]


@pytest.mark.parametrize("variation", range(12))
def test_expert_brings_the_cup_to_its_target(world: World, variation: int) -> None:
    world.reset(variation + 20, variation)
    sequence, colour = divmod(variation, 3)
    assert world.task.sequence == sequence and not world.task.success(world)
    pose = "upward" if sequence in (CLAMP, SLIDE) else "upside-down"
    target = ("blue", "green", "yellow")[colour]
    assert world.task.description == f"move the {pose} cup to the {target} target"
    other = "upside-down_cup" if pose == "upward" else "upward_cup"
    bystander = world.pose(other).position
    planned = [parse(waypoint.instruction).template for waypoint in world.task.plan(world)]
    assert planned == TEMPLATES[sequence]
    assert finish(world) == planned
    cup = world.pose(f"{pose}_cup")
    assert np.linalg.norm(cup.position - world.pose(f"{target}_target").position) < 0.012
    assert cup.rotation.as_matrix()[2, 2] > 0.99
    assert np.linalg.norm(world.pose(other).position - bystander) < 0.003


@pytest.mark.parametrize("seed", range(6))
def test_words_alone_do_not_tell_the_sequence(world: World, seed: int) -> None:
    places = []
    for sequence in (CLAMP, SLIDE, TURN, PULL_OUT):
        world.reset(seed, 3 * sequence)
        roofed = {}
        for cup in ("upward_cup", "upside-down_cup"):
            gaps = [world.pose(cup).position[:2] - world.pose(name).position[:2] for name in ("ledge", "cabinet")]
            roofed[cup] = [abs(x) < 0.02 and y > 0 for x, y in gaps]
        places.append(roofed)
        assert (world.pose("upward_cup").rotation.as_matrix()[2, 2], world.task.success(world)) == (
            pytest.approx(1, abs=1e-3),
            False,
        )
    assert not any(places[CLAMP]["upward_cup"]) and places[SLIDE]["upward_cup"] == [True, False]
    assert not any(places[TURN]["upside-down_cup"]) and places[PULL_OUT]["upside-down_cup"] == [False, True]


def test_only_the_named_cup_upright_on_the_named_target_is_success(world: World) -> None:
    world.reset(0, 3 * TURN)
    blue, green = (world.pose(f"{colour}_target").position for colour in ("blue", "green"))
    for cup, spot, rotation, done in (
        ("upward_cup", green, None, False),
        ("upside-down_cup", blue + (0, 0, CUP_HEIGHT), UPSIDE_DOWN, False),
        ("upside-down_cup", blue + (0, 0.05, CUP_RADIUS), LYING, False),
        ("upside-down_cup", blue, None, True),
    ):
        put(world, cup, spot, rotation)
        assert world.task.success(world) == done


def test_the_ledge_keeps_the_hand_off_the_rim(world: World) -> None:
    world.reset(1, 3 * SLIDE)
    gap = world.pose("upward_cup").position[1] - CUP_RADIUS - world.pose("ledge").position[1]
    assert -0.02 < gap < 0
    x, y, _ = world.pose("upward_cup").position
    from_above = Pose(np.array((x, y - CUP_RADIUS, CUP_HEIGHT)), (1.0, 0.0, 0.0, 0.0))
    world.motion.execute(from_above.shifted(z=0.15), True, True)
    world.motion.execute(from_above.shifted(z=-0.013), False, True)
    assert not world.holds("upward_cup")


@pytest.mark.parametrize("variation", [3 * CLAMP, 3 * PULL_OUT])
def test_expert_takes_up_a_cup_that_fell(world: World, variation: int) -> None:
    world.reset(4, variation)
    follow(world, TEMPLATES[variation // 3].index("place"))
    assert world.held_bodies() == {f"{world.task.pose}_cup"}
    world.motion.execute(world.tool.shifted(y=0.08), True, True)
    world.advance(0.5)
    assert not world.task.success(world)
    finish(world)


@pytest.mark.parametrize("heading", np.deg2rad((-170, -80, 10, 100)))
def test_expert_sets_a_lying_cup_upright(world: World, heading: float) -> None:
    world.reset(5, 3 * CLAMP + 1)
    put(world, "upward_cup", np.array((0.48, 0.05, CUP_RADIUS)), Rotation.from_euler("z", heading) * LYING)
    assert finish(world) == ["move", "grasp", *TURNED]


def test_a_closed_hand_opens_before_it_grasps(world: World) -> None:
    world.reset(6, 3 * TURN)
    follow(world, 1)
    world.motion.execute(world.tool, False, True)
    first = world.task.plan(world)[0]
    assert first.gripper_open and parse(first.instruction).template == "move"
    finish(world)


def test_the_wrong_cup_is_let_go(world: World) -> None:
    world.reset(7, 3 * PULL_OUT)
    put(world, "upward_cup", np.array((0.5, 0.06, 0.0)))
    world.task.pose = "upward"
    follow(world, 2)
    world.task.pose = "upside-down"
    assert world.holds("upward_cup")
    assert world.task.plan(world)[0].instruction == "release the upward cup"
    finish(world)


def test_a_cup_held_by_its_bottom_is_put_down(world: World) -> None:
    world.reset(8, 3 * TURN)
    cup = world.pose("upside-down_cup").position
    from_above = Pose(cup - (0, 0, 0.02), (1.0, 0.0, 0.0, 0.0))
    world.motion.execute(from_above.shifted(z=0.1), True, True)
    world.motion.execute(from_above, False, True)
    assert world.task.plan(world)[0].instruction == "release the upside-down cup"
    finish(world)
