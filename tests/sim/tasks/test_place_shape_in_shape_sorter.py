"""The named shape goes through its own hole, and comes back from wherever it fell."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose
from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.objects.shape_sorter import BODY, PLATE_TOP, hole
from lerobot_llakey.sim.objects.shapes import SHAPES, Shape
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks.base import Waypoint
from lerobot_llakey.sim.tasks.place_shape_in_shape_sorter import PlaceShapeInShapeSorter
from lerobot_llakey.sim.world import World

CUBE, CYLINDER, TRIANGLE, STAR, MOON = range(5)
TEMPLATES = ["move", "grasp", "raise", "align", "insert", "release"]


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(PlaceShapeInShapeSorter())


def put(simulation: Simulation, shape: Shape, position: np.ndarray, rotation: Rotation | None = None) -> None:
    world = simulation.world
    world.place(shape.body, Pose(position, (rotation or Rotation.identity()).as_quat()))
    world.data.joint(shape.body).qvel[:] = 0
    simulation.clock.advance(0.6)


def follow(simulation: Simulation, waypoint: Waypoint) -> None:
    simulation.motion.execute(waypoint.pose, waypoint.gripper_open, waypoint.ignore_collision)


def over(world: World, shape: Shape, height: float) -> np.ndarray:
    return world.pose(BODY).apply(np.array((*hole(shape), PLATE_TOP + height)))


def take(simulation: Simulation, shape: Shape) -> None:
    world = simulation.world
    for waypoint in simulation.task._fetch(world, shape)[:2]:  # type: ignore[attr-defined]
        follow(simulation, waypoint)
    assert world.holds(shape.body)


@pytest.mark.parametrize("variation", range(5))
@pytest.mark.parametrize("seed", range(2))
def test_expert_puts_the_shape_through_its_hole(simulation: Simulation, variation: int, seed: int) -> None:
    world = simulation.world
    simulation.reset(seed, variation)
    shape = SHAPES[variation]
    assert not simulation.success() and shape.name in simulation.task.description
    others = {other: world.pose(other.body).position for other in SHAPES if other is not shape}
    steps = list(demonstrate(simulation))
    assert steps[-1].success and not simulation.plan()
    assert [parse(step.waypoint.instruction).template for step in steps] == TEMPLATES
    assert f"align downward with the {shape.name} hole" in [step.waypoint.instruction for step in steps]
    for other, place in others.items():
        assert np.linalg.norm(world.pose(other.body).position - place) < 0.003


def test_rlbench_order_of_variations() -> None:
    assert [shape.name for shape in SHAPES] == ["cube", "cylinder", "triangular prism", "star", "moon"]


def test_only_the_named_shape_in_its_own_compartment_is_success(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, CUBE)
    heading = world.pose(BODY).rotation
    put(simulation, SHAPES[STAR], over(world, SHAPES[STAR], 0.003), heading)
    assert world.pose("star").position[2] < 0.01 and not simulation.success()
    put(simulation, SHAPES[CUBE], over(world, SHAPES[CYLINDER], 0.003), heading)
    assert not simulation.success()
    put(simulation, SHAPES[CUBE], over(world, SHAPES[CUBE], 0.003), heading)
    assert simulation.success()


def test_a_shape_in_the_hand_is_no_success(simulation: Simulation) -> None:
    simulation.reset(1, MOON)
    for step in demonstrate(simulation):
        released = parse(step.waypoint.instruction).template == "release"
        assert step.success == released


@pytest.mark.parametrize("variation", range(5))
def test_expert_takes_up_a_shape_dropped_on_the_sorter(simulation: Simulation, variation: int) -> None:
    world = simulation.world
    simulation.reset(7, variation)
    steps = demonstrate(simulation)
    while parse(next(steps).waypoint.instruction).template != "align":
        pass
    simulation.motion.execute(world.tool.shifted(x=0.02, y=0.02), True, True)
    assert list(demonstrate(simulation))[-1].success


@pytest.mark.parametrize("variation", [CUBE, STAR])
def test_expert_finds_a_shape_that_was_turned_crosswise(simulation: Simulation, variation: int) -> None:
    world = simulation.world
    simulation.reset(3, variation)
    shape = SHAPES[variation]
    put(simulation, shape, world.pose(shape.body).position, Rotation.from_euler("z", 1.8))
    assert list(demonstrate(simulation))[-1].success


def test_a_hand_closed_above_the_shape_goes_up_and_opens(simulation: Simulation) -> None:
    simulation.reset(2, TRIANGLE)
    before, grasp = (step.pose for step in simulation.plan()[:2])
    simulation.motion.execute(grasp.shifted(z=0.03), False, True)
    first = simulation.plan()[0]
    assert first.gripper_open and first.pose.distance(before)[0] < 0.01
    assert list(demonstrate(simulation))[-1].success


def test_a_shape_beside_the_sorter_is_grasped_with_room_for_the_fingers(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(5, CUBE)
    sorter = world.pose(BODY)
    side = -np.sign(sorter.position[1])
    put(simulation, SHAPES[CUBE], sorter.apply(np.array((0.0, side * 0.12, 0.0))), sorter.rotation)
    assert list(demonstrate(simulation))[-1].success


def test_a_lying_shape_is_put_back_on_its_foot(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(4, STAR)
    take(simulation, SHAPES[STAR])
    follow(simulation, simulation.plan()[0])
    hand = world.tool.position
    # Turned in the hand by a quarter: what a grasp of a lying shape gives.
    address = world.model.joint("star").qposadr[0]
    turned = world.tool.rotation * Rotation.from_euler("y", np.pi / 2) * Rotation.from_euler("x", np.pi)
    x, y, z, w = turned.as_quat()
    world.data.qpos[address : address + 7] = (*(hand - turned.apply((0, 0, 0.041))), w, x, y, z)
    simulation.clock.advance(0.1)
    plan = simulation.plan()
    assert "place the star on the table" in [step.instruction for step in plan]
    assert list(demonstrate(simulation))[-1].success


def test_a_wrong_shape_in_the_hand_is_let_go_where_it_stood(simulation: Simulation) -> None:
    simulation.reset(0, CUBE)
    take(simulation, SHAPES[STAR])
    assert simulation.plan()[0].instruction == "release the star"
    assert list(demonstrate(simulation))[-1].success


def test_a_wrong_shape_on_the_hole_is_put_aside(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, CUBE)
    put(simulation, SHAPES[STAR], over(world, SHAPES[CUBE], 0.003))
    steps = list(demonstrate(simulation))
    assert steps[0].waypoint.instruction == "move to the top of the star"
    assert "place the star on the table" in [step.waypoint.instruction for step in steps]
    assert steps[-1].success


@pytest.mark.parametrize("degrees", [-50, 50])
def test_a_shape_that_is_turned_above_its_hole_is_lowered_and_turned_at_once(
    simulation: Simulation, degrees: float
) -> None:
    world = simulation.world
    simulation.reset(1, STAR)
    take(simulation, SHAPES[STAR])
    raised, align = simulation.plan()[:2]
    follow(simulation, raised)
    place = over(world, SHAPES[STAR], 0.025)
    turn = Rotation.from_euler("z", degrees, degrees=True) * align.pose.rotation
    grip = world.tool.inverse() @ world.pose(SHAPES[STAR].body)
    follow(simulation, Waypoint(Pose(place - turn.apply(grip.position), turn.as_quat()), False, False, ""))
    for template in ("insert", "release"):
        waypoint = simulation.plan()[0]
        assert parse(waypoint.instruction).template == template
        follow(simulation, waypoint)
    assert simulation.success()
