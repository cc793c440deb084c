"""Plans are straight where they may be, go around things, and say why there is none."""

import itertools

import mujoco
import numpy as np
import pytest

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.sim.arm.panda import HOME_JOINTS
from lerobot_llakey.sim.arm.planning import PlanningError
from lerobot_llakey.sim.world import World


def _plan(world: World, target: Pose, ignore_collision: bool = False) -> np.ndarray:
    planner = world.motion.planner
    return planner.plan(world.data, target, ignore_collision, [], np.random.default_rng(0))


def test_free_moves_are_straight(drawer_world: World) -> None:
    drawer_world.reset(3)
    start, target = drawer_world.tool, Pose(np.array([0.4, 0.2, 0.3]), top_down(0.4))
    path = _plan(drawer_world, target)
    line = (target.position - start.position) / np.linalg.norm(target.position - start.position)
    for joints in path:
        offset = drawer_world.kinematics.forward(joints).position - start.position
        assert np.linalg.norm(offset - line * (offset @ line)) < 5e-3
    assert drawer_world.kinematics.forward(path[-1]).distance(target)[0] < 1e-3


def test_a_cabinet_in_the_straight_way_is_gone_around(drawer_world: World) -> None:
    drawer_world.reset(3)
    world, model = drawer_world, drawer_world.model
    sides = [model.body("cabinet").pos + [-0.05, y, 0.12] for y in (-0.3, 0.3)]
    start, target = (Pose(np.array(side), top_down()) for side in sides)
    joints = world.kinematics.solve_from_many(start, HOME_JOINTS, np.random.default_rng(0))
    assert joints is not None
    world.data.qpos[world.robot.qpos] = joints
    mujoco.mj_forward(model, world.data)

    def free(path: np.ndarray) -> bool:
        between = [a + t * (b - a) for a, b in itertools.pairwise(path) for t in np.linspace(0, 1, 20)]
        return world.motion.planner._is_free(np.stack(between), joints, ())

    straight, around = _plan(world, target, ignore_collision=True), _plan(world, target)
    assert not free(straight) and free(around)
    for path in (straight, around):
        assert np.array_equal(path[0], joints)
        assert world.kinematics.forward(path[-1]).distance(target)[0] < 1e-3


def test_planning_leaves_the_scene_alone(drawer_world: World) -> None:
    drawer_world.reset(3)
    before = drawer_world.data.qpos.copy()
    _plan(drawer_world, Pose(np.array([0.4, -0.2, 0.3]), top_down()))
    assert np.array_equal(before, drawer_world.data.qpos)


def test_out_of_reach_is_told(drawer_world: World) -> None:
    drawer_world.reset(3)
    with pytest.raises(PlanningError) as error:
        _plan(drawer_world, Pose(np.array([1.5, 0.0, 0.3]), top_down()))
    assert error.value.reason == "unreachable"


def test_a_pose_inside_the_table_collides_unless_allowed(drawer_world: World) -> None:
    drawer_world.reset(3)
    inside = Pose(np.array([0.4, 0.0, -0.02]), top_down())
    with pytest.raises(PlanningError) as error:
        _plan(drawer_world, inside)
    assert error.value.reason == "collision"
    assert len(_plan(drawer_world, inside, ignore_collision=True)) > 1
