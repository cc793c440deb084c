"""Bottles go into the rack from whatever state they are in."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.objects.wine import LYING_HEIGHT, MIDDLE, slot_y
from lerobot_llakey.sim.objects.wine_placements import lying
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.tasks.base import Waypoint

COLOURS = ("red", "green", "yellow")
PUT = ["move", "place", "release"]
TEMPLATES = (
    ["move", "grasp", "raise", *PUT],
    ["move", "grasp", "raise", "rotate", *PUT],
    ["move", "grasp", "raise", "rotate", "rotate", *PUT],
)
RED_LEFT, GREEN_MIDDLE, YELLOW_RIGHT = 0, 4, 8


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(make_task("stack_wine"))


def follow(simulation: Simulation, waypoint: Waypoint) -> None:
    simulation.motion.execute(waypoint.pose, waypoint.gripper_open, waypoint.ignore_collision)


def act(simulation: Simulation, pose: Pose, gripper_open: bool) -> None:
    simulation.motion.execute(pose, gripper_open, True)


def lay_in(simulation: Simulation, colour: str, slot: str, turn: float = 0.0) -> None:
    """Let a bottle go just above a cradle, its neck turned away from where it belongs by ``turn``."""
    world = simulation.world
    rotation = Rotation.from_euler("z", turn) * Rotation.from_euler("y", np.pi / 2)
    middle = np.array((0.0, slot_y(slot), LYING_HEIGHT + 0.004))
    world.place(colour, world.pose("rack") @ Pose(middle - rotation.apply((0, 0, MIDDLE)), rotation.as_quat()))
    simulation.clock.advance(0.6)


@pytest.mark.parametrize("variation", range(9))
def test_expert_lays_the_bottle_in_its_slot(simulation: Simulation, variation: int) -> None:
    world = simulation.world
    simulation.reset(variation, variation)
    bottle, slot = divmod(variation, 3)
    colour, name = COLOURS[bottle], ("left", "middle", "right")[slot]
    assert simulation.task.sequence == bottle and not simulation.success()
    assert simulation.task.description == f"stack the {colour} wine bottle to the {name} of the rack"
    others = {other: world.pose(other).position for other in COLOURS if other != colour}
    steps = list(demonstrate(simulation))
    assert steps[-1].success and not simulation.plan()
    assert [parse(step.waypoint.instruction).template for step in steps] == TEMPLATES[bottle]
    assert len({step.waypoint.instruction for step in steps}) == len(steps)
    for other, place in others.items():
        assert np.linalg.norm(world.pose(other).position - place) < 0.005


def test_only_that_bottle_that_slot_and_that_way_round_succeed(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(1, RED_LEFT)
    away = world.pose("red")
    for colour, slot, turn, done in (
        ("green", "left", 0.0, False),
        ("red", "middle", 0.0, False),
        ("red", "left", np.pi, False),
        ("red", "left", 0.0, True),
    ):
        lay_in(simulation, colour, slot, turn)
        assert simulation.success() == done, (colour, slot, turn)
        world.place(colour, away.shifted(z=0.3))


def test_a_bottle_still_in_the_hand_is_no_success(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(2, RED_LEFT)
    steps = demonstrate(simulation)
    while parse(next(steps).waypoint.instruction).template != "place":
        pass
    assert world.holds("red") and not simulation.success()


@pytest.mark.parametrize("variation", [RED_LEFT, GREEN_MIDDLE, YELLOW_RIGHT])
@pytest.mark.parametrize("heading", [-150, -60, 45, 110])
def test_expert_takes_a_bottle_that_lies_in_any_heading(simulation: Simulation, variation: int, heading: int) -> None:
    world = simulation.world
    simulation.reset(3, variation)
    colour = COLOURS[variation // 3]
    for side, other in zip((-0.5, 0.5), (other for other in COLOURS if other != colour), strict=True):
        world.place(other, Pose(np.array((0.2, side, 0.03))))
    world.place("rack", Pose(np.array((0.53, 0.12, 0.0)), Rotation.from_euler("z", 0.15).as_quat()))
    world.place(colour, lying(np.array((0.5, -0.18)), np.deg2rad(heading)))
    simulation.clock.advance(0.4)
    assert list(demonstrate(simulation))[-1].success


@pytest.mark.parametrize(
    ("variation", "carried"), [(RED_LEFT, 4), (GREEN_MIDDLE, 3), (GREEN_MIDDLE, 5), (YELLOW_RIGHT, 5)]
)
def test_expert_takes_up_a_bottle_that_it_lost_on_the_way(simulation: Simulation, variation: int, carried: int) -> None:
    world = simulation.world
    simulation.reset(4, variation)
    for _ in range(carried):
        follow(simulation, simulation.plan()[0])
    assert world.holds(COLOURS[variation // 3])
    act(simulation, world.tool.shifted(x=-0.04), True)
    simulation.clock.advance(0.5)
    assert not simulation.success()
    assert list(demonstrate(simulation))[-1].success


def test_expert_turns_a_bottle_that_lies_in_its_slot_the_wrong_way_round(simulation: Simulation) -> None:
    simulation.reset(6, GREEN_MIDDLE)
    lay_in(simulation, "green", "middle", np.pi)
    steps = list(demonstrate(simulation))
    assert steps[-1].success
    assert [parse(step.waypoint.instruction).template for step in steps][:5] == TEMPLATES[2][:5]


def test_a_closed_hand_opens_before_it_grasps_again(simulation: Simulation) -> None:
    simulation.reset(5, RED_LEFT)
    above = simulation.plan()[0]
    act(simulation, above.pose, False)
    assert simulation.plan()[0].gripper_open
    assert list(demonstrate(simulation))[-1].success


def test_the_wrong_bottle_is_let_go(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, RED_LEFT)
    axis = world.pose("yellow").rotation.as_matrix()[:, 2]
    grasp = Pose(world.pose("yellow").apply(np.array((0, 0, 0.075))), top_down(float(np.arctan2(axis[1], axis[0]))))
    act(simulation, grasp.shifted(z=0.12), True)
    act(simulation, grasp, False)
    assert simulation.plan()[0].instruction == "release the yellow wine bottle"
    assert list(demonstrate(simulation))[-1].success
