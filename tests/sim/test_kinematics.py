"""Inverse kinematics undoes forward kinematics, nearby and continuously."""

import numpy as np
import pytest

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.sim.robot import HOME_JOINTS
from lerobot_llakey.sim.world import World


@pytest.mark.parametrize("seed", range(20))
def test_solution_reaches_the_target(drawer_world: World, seed: int) -> None:
    rng = np.random.default_rng(seed)
    kinematics = drawer_world.kinematics
    target = kinematics.forward(HOME_JOINTS + rng.uniform(-0.4, 0.4, 7))
    joints = kinematics.solve(target, HOME_JOINTS)
    assert joints is not None
    distance, angle = kinematics.forward(joints).distance(target)
    assert distance < 1e-3 and angle < 1e-2
    assert (joints > drawer_world.robot.limits[:, 0]).all() and (joints < drawer_world.robot.limits[:, 1]).all()


def test_jacobian_agrees_with_finite_differences(drawer_world: World) -> None:
    kinematics, step = drawer_world.kinematics, 1e-4
    start = kinematics.forward(HOME_JOINTS)
    for joint in range(7):
        moved = kinematics.forward(HOME_JOINTS + step * np.eye(7)[joint])
        back = kinematics.solve(moved, HOME_JOINTS, position_tolerance=1e-6, angle_tolerance=1e-5)
        assert back is not None
        assert kinematics.forward(back).distance(moved)[0] < 2e-6
        assert start.distance(moved)[0] < step


def test_a_pose_out_of_reach_has_no_solution(drawer_world: World) -> None:
    far = Pose(np.array([2.0, 0.0, 0.3]), top_down())
    rng = np.random.default_rng(0)
    assert drawer_world.kinematics.solve_from_many(far, HOME_JOINTS, rng) is None
