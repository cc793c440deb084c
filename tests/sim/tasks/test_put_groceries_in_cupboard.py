"""One good goes on to the shelf, whatever happens to it on the way."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.objects.groceries import GOODS
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.world import World

TEMPLATES = ["move", "grasp", "raise", "move", "place", "release"]
CRACKERS, _, JELLO, SOUP, TUNA, _, COFFEE, MUSTARD, _ = range(9)
LYING = Rotation.from_euler("x", np.pi / 2)


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(make_task("put_groceries_in_cupboard"))


def put(simulation: Simulation, good: int, position: np.ndarray, rotation: Rotation | None = None) -> None:
    world = simulation.world
    world.place(GOODS[good].body, Pose(position, (rotation or Rotation.identity()).as_quat()))
    simulation.clock.advance(0.5)


def act(simulation: Simulation, pose: Pose, gripper_open: bool) -> None:
    simulation.motion.execute(pose, gripper_open, True)


def follow(simulation: Simulation, count: int) -> None:
    for _ in range(count):
        waypoint = simulation.plan()[0]
        simulation.motion.execute(waypoint.pose, waypoint.gripper_open, waypoint.ignore_collision)


def shown(world: World) -> list[int]:
    return [index for index, good in enumerate(GOODS) if world.pose(good.body).position[2] > 0]


@pytest.mark.parametrize("variation", range(9))
def test_expert_puts_each_good_on_the_shelf(simulation: Simulation, variation: int) -> None:
    world = simulation.world
    simulation.reset(variation, variation)
    name = GOODS[variation].name
    assert not simulation.success() and name in simulation.task.description
    others = {index: world.pose(GOODS[index].body).position for index in shown(world) if index != variation}
    assert len(others) == 4
    steps = list(demonstrate(simulation))
    assert steps[-1].success and not simulation.plan()
    assert [parse(step.waypoint.instruction).template for step in steps] == TEMPLATES
    assert steps[1].waypoint.instruction == f"grasp the {name}"
    for index, before in others.items():
        assert np.linalg.norm(world.pose(GOODS[index].body).position - before) < 0.01


def test_the_wording_varies_and_names_the_good(simulation: Simulation) -> None:
    wordings = set()
    for seed in range(12):
        simulation.reset(seed, JELLO)
        wordings.add(simulation.task.description.replace("strawberry jello", "{}"))
    assert "put the {} in the cupboard" in wordings and len(wordings) == 4


def test_goods_out_of_use_stay_out_of_sight_and_still(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(3, SOUP)
    hidden = [good.body for index, good in enumerate(GOODS) if index not in shown(world)]
    before = [world.pose(body).position for body in hidden]
    assert all(position[2] < -0.6 for position in before)
    simulation.clock.advance(2.0)
    assert np.abs(np.subtract(before, [world.pose(body).position for body in hidden])).max() < 0.001


def test_another_good_or_one_on_the_roof_is_no_success(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(1, SOUP)
    other = next(index for index in shown(world) if index != SOUP)
    cupboard = world.pose("cupboard")
    put(simulation, other, cupboard.apply(np.array((0.06, 0.0, 0.07))))
    assert not simulation.success()
    put(simulation, SOUP, cupboard.apply(np.array((0.135, 0.0, 0.18))))
    assert world.pose("soup").position[2] > 0.12 and not simulation.success()
    put(simulation, SOUP, cupboard.apply(np.array((0.06, 0.09, 0.06))))
    assert simulation.success()


def test_a_good_in_the_hand_is_no_success(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(2, TUNA)
    follow(simulation, 5)
    assert world.holds("tuna") and not simulation.success()
    assert [step.instruction for step in simulation.plan()] == ["release the tuna"]


@pytest.mark.parametrize("variation", [CRACKERS, COFFEE, MUSTARD])
@pytest.mark.parametrize("yaw", [0.2, 1.2])
def test_expert_takes_up_what_lies_on_its_side(simulation: Simulation, variation: int, yaw: float) -> None:
    world = simulation.world
    simulation.reset(4, variation)
    position = world.pose(GOODS[variation].body).position
    put(simulation, variation, position, Rotation.from_euler("z", yaw) * LYING)
    assert list(demonstrate(simulation))[-1].success


@pytest.mark.parametrize("count", [3, 4])
def test_expert_takes_up_what_it_lost_on_the_way(simulation: Simulation, count: int) -> None:
    world = simulation.world
    simulation.reset(5, SOUP)
    follow(simulation, count)
    assert world.holds("soup")
    act(simulation, world.tool, True)
    simulation.clock.advance(1.0)
    assert not simulation.success()
    assert simulation.plan()[0].instruction == "move to the top of the soup"
    assert list(demonstrate(simulation))[-1].success


def test_expert_reaches_over_the_shelf_for_what_lies_before_it(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(6, CRACKERS)
    cupboard = world.pose("cupboard")
    flat = cupboard.rotation * Rotation.from_euler("xz", (np.pi / 2, np.pi / 2))
    put(simulation, CRACKERS, cupboard.apply(np.array((-0.02, 0.0, 0.03))), cupboard.rotation * flat)
    assert list(demonstrate(simulation))[-1].success


def test_a_closed_hand_opens_before_it_grasps(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(7, COFFEE)
    follow(simulation, 1)
    act(simulation, world.tool, False)
    step = simulation.plan()[0]
    assert step.gripper_open and step.instruction == "move to the top of the coffee"


def test_the_wrong_good_is_let_go(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, SOUP)
    other = next(index for index in shown(world) if index != SOUP)
    pose = world.pose(GOODS[other].body)
    grasp = Pose(pose.position, top_down(float(pose.rotation.as_euler("zyx")[0])))
    act(simulation, grasp.shifted(z=0.1), True)
    act(simulation, grasp, False)
    assert simulation.plan()[0].instruction == f"release the {GOODS[other].name}"
    assert list(demonstrate(simulation))[-1].success


def test_expert_leaves_another_good_its_place_on_the_shelf(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(1, CRACKERS)
    other = next(index for index in shown(world) if index != CRACKERS)
    cupboard = world.pose("cupboard")
    put(simulation, other, cupboard.apply(np.array((0.062, 0.01, 0.07))))
    before = world.pose(GOODS[other].body).position
    steps = list(demonstrate(simulation))
    assert steps[-1].success and len(steps) == len(TEMPLATES)
    assert np.linalg.norm(world.pose(GOODS[other].body).position - before) < 0.01


def test_a_hand_does_not_press_a_good_through_the_table(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, TUNA)
    position = world.pose("tuna").position
    act(simulation, Pose(position, top_down()).shifted(z=0.1), False)
    act(simulation, Pose(position * (1, 1, 0), top_down()), False)
    assert world.pose("tuna").position[2] > 0.01
