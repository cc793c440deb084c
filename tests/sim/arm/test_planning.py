"""Plans are straight where they may be, go around things, and say why there is none."""

import itertools

import mujoco
import numpy as np
import pytest

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.sim.arm.panda import HOME_JOINTS
from lerobot_llakey.sim.arm.planning import PlanningError
from lerobot_llakey.sim.simulation import Simulation


def _plan(simulation: Simulation, target: Pose, ignore_collision: bool = False) -> np.ndarray:
    world = simulation.world
    planner = world.planner
    return planner.plan(world.data, target, ignore_collision, [], np.random.default_rng(0))


def test_free_moves_are_straight(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(3)
    start, target = world.tool, Pose(np.array([0.4, 0.2, 0.3]), top_down(0.4))
    path = _plan(simulation, target)
    line = (target.position - start.position) / np.linalg.norm(target.position - start.position)
    for joints in path:
        offset = world.planner.kinematics.forward(joints).position - start.position
        assert np.linalg.norm(offset - line * (offset @ line)) < 5e-3
    assert world.planner.kinematics.forward(path[-1]).distance(target)[0] < 1e-3


def test_a_cabinet_in_the_straight_way_is_gone_around(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(3)
    model = world.model
    sides = [model.body("cabinet").pos + [-0.05, y, 0.12] for y in (-0.3, 0.3)]
    start, target = (Pose(np.array(side), top_down()) for side in sides)
    joints = world.planner.kinematics.solve_from_many(start, HOME_JOINTS, np.random.default_rng(0))
    assert joints is not None
    world.data.qpos[world.robot.qpos] = joints
    mujoco.mj_forward(model, world.data)

    def free(path: np.ndarray) -> bool:
        between = [a + t * (b - a) for a, b in itertools.pairwise(path) for t in np.linspace(0, 1, 20)]
        return world.planner._is_free(np.stack(between), joints, ())

    straight, around = _plan(simulation, target, ignore_collision=True), _plan(simulation, target)
    assert not free(straight) and free(around)
    for path in (straight, around):
        assert np.array_equal(path[0], joints)
        assert world.planner.kinematics.forward(path[-1]).distance(target)[0] < 1e-3


@pytest.mark.parametrize("ignore_collision", [False, True])
def test_where_no_straight_line_leads_the_arm_swings_around_its_base(
    simulation: Simulation, ignore_collision: bool
) -> None:
    world = simulation.world
    simulation.reset(3)
    planner, rng = world.planner, np.random.default_rng(0)
    right, left = (Pose(np.array((0.0, y, 0.35)), top_down()) for y in (-0.5, 0.5))
    joints = planner.kinematics.solve_from_many(right, HOME_JOINTS, rng)
    assert joints is not None
    world.data.qpos[world.robot.qpos] = joints
    mujoco.mj_forward(world.model, world.data)
    assert planner._straight_line(world.tool, left, joints) is None
    path = _plan(simulation, left, ignore_collision)
    assert planner.kinematics.forward(path[-1]).distance(left)[0] < 1e-3
    between = [a + t * (b - a) for a, b in itertools.pairwise(path) for t in np.linspace(0, 1, 50)]
    positions = np.array([planner.kinematics.forward(at).position for at in between])
    assert np.hypot(positions[:, 0], positions[:, 1]).min() > 0.15
    assert planner._is_free(np.stack(between), joints, ())


def test_planning_leaves_the_scene_alone(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(3)
    before = world.data.qpos.copy()
    _plan(simulation, Pose(np.array([0.4, -0.2, 0.3]), top_down()))
    assert np.array_equal(before, world.data.qpos)


def test_out_of_reach_is_told(simulation: Simulation) -> None:
    simulation.reset(3)
    with pytest.raises(PlanningError) as error:
        _plan(simulation, Pose(np.array([1.5, 0.0, 0.3]), top_down()))
    assert error.value.reason == "unreachable"


def test_a_pose_inside_the_table_collides_unless_allowed(simulation: Simulation) -> None:
    simulation.reset(3)
    inside = Pose(np.array([0.4, 0.0, -0.02]), top_down())
    with pytest.raises(PlanningError) as error:
        _plan(simulation, inside)
    assert error.value.reason == "collision"
    assert len(_plan(simulation, inside, ignore_collision=True)) > 1
