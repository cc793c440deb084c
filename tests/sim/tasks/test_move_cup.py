"""Cups go to their targets, each by the way its place and pose ask for."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose
from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.objects.cup import CUP_HEIGHT, CUP_RADIUS
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks.move_cup import CLAMP, PULL_OUT, SLIDE, TURN, MoveCup

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
def simulation() -> Simulation:
    return Simulation(MoveCup())


def put(simulation: Simulation, cup: str, position: np.ndarray, rotation: Rotation | None = None) -> None:
    world = simulation.world
    world.place(cup, Pose(position, (rotation or Rotation.identity()).as_quat()))
    simulation.clock.advance(0.5)


def follow(simulation: Simulation, count: int) -> None:
    for _ in range(count):
        waypoint = simulation.plan()[0]
        simulation.motion.execute(waypoint.pose, waypoint.gripper_open, waypoint.ignore_collision)


def finish(simulation: Simulation) -> list[str]:
    """The templates of the instructions that the expert followed to the end."""
    steps = list(demonstrate(simulation))
    assert steps[-1].success and not simulation.plan()
    return [parse(step.waypoint.instruction).template for step in steps]


@pytest.mark.parametrize("variation", range(12))
def test_expert_brings_the_cup_to_its_target(simulation: Simulation, variation: int) -> None:
    world = simulation.world
    simulation.reset(variation + 20, variation)
    sequence, colour = divmod(variation, 3)
    assert simulation.task.sequence == sequence and not simulation.success()
    pose = "upward" if sequence in (CLAMP, SLIDE) else "upside-down"
    target = ("blue", "green", "yellow")[colour]
    assert simulation.task.description == f"move the {pose} cup to the {target} target"
    other = "upside-down_cup" if pose == "upward" else "upward_cup"
    bystander = world.pose(other).position
    planned = [parse(waypoint.instruction).template for waypoint in simulation.plan()]
    assert planned == TEMPLATES[sequence]
    assert finish(simulation) == planned
    cup = world.pose(f"{pose}_cup")
    assert np.linalg.norm(cup.position - world.pose(f"{target}_target").position) < 0.012
    assert cup.rotation.as_matrix()[2, 2] > 0.99
    assert np.linalg.norm(world.pose(other).position - bystander) < 0.003


@pytest.mark.parametrize("seed", range(6))
def test_words_alone_do_not_tell_the_sequence(simulation: Simulation, seed: int) -> None:
    world = simulation.world
    places = []
    for sequence in (CLAMP, SLIDE, TURN, PULL_OUT):
        simulation.reset(seed, 3 * sequence)
        roofed = {}
        for cup in ("upward_cup", "upside-down_cup"):
            gaps = [world.pose(cup).position[:2] - world.pose(name).position[:2] for name in ("ledge", "cabinet")]
            roofed[cup] = [abs(x) < 0.02 and y > 0 for x, y in gaps]
        places.append(roofed)
        assert (world.pose("upward_cup").rotation.as_matrix()[2, 2], simulation.success()) == (
            pytest.approx(1, abs=1e-3),
            False,
        )
    assert not any(places[CLAMP]["upward_cup"]) and places[SLIDE]["upward_cup"] == [True, False]
    assert not any(places[TURN]["upside-down_cup"]) and places[PULL_OUT]["upside-down_cup"] == [False, True]


def test_only_the_named_cup_upright_on_the_named_target_is_success(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, 3 * TURN)
    blue, green = (world.pose(f"{colour}_target").position for colour in ("blue", "green"))
    for cup, position, rotation, done in (
        ("upward_cup", green, None, False),
        ("upside-down_cup", blue + (0, 0, CUP_HEIGHT), UPSIDE_DOWN, False),
        ("upside-down_cup", blue + (0, 0.05, CUP_RADIUS), LYING, False),
        ("upside-down_cup", blue, None, True),
    ):
        put(simulation, cup, position, rotation)
        assert simulation.success() == done


def test_the_ledge_keeps_the_hand_off_the_rim(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(1, 3 * SLIDE)
    gap = world.pose("upward_cup").position[1] - CUP_RADIUS - world.pose("ledge").position[1]
    assert -0.02 < gap < 0
    x, y, _ = world.pose("upward_cup").position
    from_above = Pose(np.array((x, y - CUP_RADIUS, CUP_HEIGHT)), (1.0, 0.0, 0.0, 0.0))
    simulation.motion.execute(from_above.shifted(z=0.15), True, True)
    simulation.motion.execute(from_above.shifted(z=-0.013), False, True)
    assert not world.holds("upward_cup")


@pytest.mark.parametrize("variation", [3 * CLAMP, 3 * PULL_OUT])
def test_expert_takes_up_a_cup_that_fell(simulation: Simulation, variation: int) -> None:
    world = simulation.world
    simulation.reset(4, variation)
    follow(simulation, TEMPLATES[variation // 3].index("place"))
    assert world.held_bodies() == {f"{simulation.task.pose}_cup"}
    simulation.motion.execute(world.tool.shifted(y=0.08), True, True)
    simulation.clock.advance(0.5)
    assert not simulation.success()
    finish(simulation)


@pytest.mark.parametrize("heading", np.deg2rad((-170, -80, 10, 100)))
def test_expert_sets_a_lying_cup_upright(simulation: Simulation, heading: float) -> None:
    simulation.reset(5, 3 * CLAMP + 1)
    put(simulation, "upward_cup", np.array((0.48, 0.05, CUP_RADIUS)), Rotation.from_euler("z", heading) * LYING)
    assert finish(simulation) == ["move", "grasp", *TURNED]


def test_a_closed_hand_opens_before_it_grasps(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(6, 3 * TURN)
    follow(simulation, 1)
    simulation.motion.execute(world.tool, False, True)
    first = simulation.plan()[0]
    assert first.gripper_open and parse(first.instruction).template == "move"
    finish(simulation)


def test_the_wrong_cup_is_let_go(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(7, 3 * PULL_OUT)
    put(simulation, "upward_cup", np.array((0.5, 0.06, 0.0)))
    simulation.task.pose = "upward"
    follow(simulation, 2)
    simulation.task.pose = "upside-down"
    assert world.holds("upward_cup")
    assert simulation.plan()[0].instruction == "release the upward cup"
    finish(simulation)


def test_a_cup_held_by_its_bottom_is_put_down(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(8, 3 * TURN)
    cup = world.pose("upside-down_cup").position
    from_above = Pose(cup - (0, 0, 0.02), (1.0, 0.0, 0.0, 0.0))
    simulation.motion.execute(from_above.shifted(z=0.1), True, True)
    simulation.motion.execute(from_above, False, True)
    assert simulation.plan()[0].instruction == "release the upside-down cup"
    finish(simulation)
