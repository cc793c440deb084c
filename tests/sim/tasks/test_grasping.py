"""A hand that waits near enough may begin its grasp; the grasp turns it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.tasks.grasping import grasping, points_alike, waits_before

TURNED = ["put_groceries_in_cupboard", "place_shape_in_shape_sorter", "stack_wine", "move_block", "close_jar"]


def seen_from(tool: Pose, offset: tuple[float, float, float], axis: str = "z", degrees: float = 0.0) -> Pose:
    """A place beside the tool, turned about one of the tool's axes."""
    turn = Rotation.from_euler(axis, degrees, degrees=True)
    return Pose(tool.position + offset, (tool.rotation * turn).as_quat())


@pytest.mark.parametrize(
    ("offset", "axis", "degrees", "waits"),
    [
        ((0, 0, 0), "z", 0, True),
        ((0.04, 0, 0), "z", 0, True),
        ((0.06, 0, 0), "z", 0, False),
        ((0, 0, 0), "z", 55, True),
        ((0, 0, 0), "z", -55, True),
        ((0, 0, 0), "z", 65, False),
        ((0, 0, 0), "x", 15, True),
        ((0, 0, 0), "x", 25, False),
        ((0, 0, 0), "y", 180, False),
    ],
)
def test_distance_lean_and_spin_have_their_own_limits(
    simulation: Simulation, offset: tuple[float, float, float], axis: str, degrees: float, waits: bool
) -> None:
    world = simulation.world
    simulation.reset(0, 0)
    assert waits_before(world, seen_from(world.tool, offset, axis, degrees)) is waits


def test_limits_are_settings(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, 0)
    assert not waits_before(world, seen_from(world.tool, (0.04, 0, 0)), near=0.02)
    assert not waits_before(world, seen_from(world.tool, (0, 0, 0), "z", 30), spin=0.3)


def test_a_closed_hand_does_not_wait(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, 0)
    here = world.tool
    simulation.motion.execute(here, False, False)
    assert not waits_before(world, world.tool)


def test_a_grasp_begins_at_its_second_step_where_the_hand_waits(simulation: Simulation) -> None:
    simulation.reset(0)
    world, here = simulation.world, simulation.world.tool
    far = here.shifted(x=0.2)
    both = grasping(world, far, far.shifted(z=-0.1), "top", "the cup")
    assert [step.instruction for step in both] == ["move to the top of the cup", "grasp the cup"]
    assert [step.gripper_open for step in both] == [True, False]
    assert [step.instruction for step in grasping(world, here, far, "top", "the cup")] == ["grasp the cup"]


def test_spin_is_told_from_lean() -> None:
    hand = Pose(np.zeros(3), Rotation.from_euler("xyz", (20, -40, 70), degrees=True).as_quat())
    assert points_alike(hand, seen_from(hand, (0, 0, 0), "z", 80), spin=np.deg2rad(85))
    assert not points_alike(hand, seen_from(hand, (0, 0, 0), "x", 30), spin=np.pi)


@pytest.mark.parametrize("task", TURNED)
def test_an_expert_whose_hand_is_turned_grasps_at_once_and_succeeds(task: str) -> None:
    simulation = Simulation(make_task(task))
    simulation.reset(3, 0)
    first = simulation.plan()[0]
    turned = seen_from(first.pose, (0, 0, 0), "z", 50)
    simulation.motion.execute(turned, first.gripper_open, first.ignore_collision)
    assert "grasp" in simulation.plan()[0].instruction
    for _ in range(12):
        if not (remaining := simulation.plan()):
            break
        simulation.motion.execute(remaining[0].pose, remaining[0].gripper_open, remaining[0].ignore_collision)
    assert simulation.success()
