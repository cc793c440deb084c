"""Inverse kinematics undoes forward kinematics, nearby and continuously."""

import mujoco
import numpy as np
import pytest

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.sim.arm.kinematics import Kinematics, _step
from lerobot_llakey.sim.arm.panda import HOME_JOINTS
from lerobot_llakey.sim.simulation import Simulation


@pytest.mark.parametrize("seed", range(20))
def test_solution_reaches_the_target(simulation: Simulation, seed: int) -> None:
    rng = np.random.default_rng(seed)
    kinematics = simulation.world.planner.kinematics
    target = kinematics.forward(HOME_JOINTS + rng.uniform(-0.4, 0.4, 7))
    joints = kinematics.solve(target, HOME_JOINTS)
    assert joints is not None
    distance, angle = kinematics.forward(joints).distance(target)
    assert distance < 1e-3 and angle < 1e-2
    assert (joints > simulation.world.robot.limits[:, 0]).all() and (joints < simulation.world.robot.limits[:, 1]).all()


def test_a_small_turn_of_any_joint_is_undone(simulation: Simulation) -> None:
    kinematics, step = simulation.world.planner.kinematics, 1e-4
    start = kinematics.forward(HOME_JOINTS)
    for joint in range(7):
        moved = kinematics.forward(HOME_JOINTS + step * np.eye(7)[joint])
        back = kinematics.solve(moved, HOME_JOINTS, position_tolerance=1e-6, angle_tolerance=1e-5)
        assert back is not None
        assert kinematics.forward(back).distance(moved)[0] < 2e-6
        assert start.distance(moved)[0] < step


def _difference(after: Pose, before: Pose) -> np.ndarray:
    """How far (6,) the tool moved and turned, in metres and radians."""
    return np.concatenate((after.position - before.position, (after.rotation * before.rotation.inv()).as_rotvec()))


def _jacobian(kinematics: Kinematics, joints: np.ndarray) -> np.ndarray:
    """Of the tool (6, 7), by finite differences."""
    step = 1e-5 * np.eye(7)
    ends = [(kinematics.forward(joints + turn), kinematics.forward(joints - turn)) for turn in step]
    return np.stack([_difference(*both) / 2e-5 for both in ends], axis=1)


def test_one_step_moves_the_tool_as_asked_with_the_jacobian_of_finite_differences(simulation: Simulation) -> None:
    kinematics, error = simulation.world.planner.kinematics, np.array([2e-3, -1e-3, 1.5e-3, 4e-3, -2e-3, -3e-3])
    jacobian, (lower, upper) = _jacobian(kinematics, HOME_JOINTS), simulation.world.robot.limits.T.copy()
    start = kinematics.forward(HOME_JOINTS)
    step = _step(jacobian, error, HOME_JOINTS, lower, upper)
    assert np.linalg.norm(_difference(kinematics.forward(HOME_JOINTS + step), start) - error) < 0.05 * np.linalg.norm(
        error
    )
    # The joint that moves most is put at its limit: it stays, and the others do what they can.
    most = int(np.abs(step).argmax())
    (upper if step[most] > 0 else lower)[most] = HOME_JOINTS[most]
    held = _step(jacobian, error, HOME_JOINTS, lower, upper)
    assert held[most] == 0.0
    left = error - _difference(kinematics.forward(HOME_JOINTS + held), start)
    assert np.linalg.norm(left) < 0.5 * np.linalg.norm(error)


def test_the_scenes_jacobian_is_that_of_finite_differences(simulation: Simulation) -> None:
    # What solve() takes from MuJoCo: the right site, and the arm's columns in the order of its joints.
    kinematics, robot = simulation.world.planner.kinematics, simulation.world.robot
    for joints in (HOME_JOINTS, HOME_JOINTS + 0.2):
        expected, found = _jacobian(kinematics, joints), np.zeros((6, kinematics.model.nv))
        kinematics.place(joints)
        mujoco.mj_jacSite(kinematics.model, kinematics.scratch, found[:3], found[3:], robot.tcp)
        assert np.allclose(found[:, robot.dofs], expected, atol=1e-7)


def test_a_pose_out_of_reach_has_no_solution(simulation: Simulation) -> None:
    far = Pose(np.array([2.0, 0.0, 0.3]), top_down())
    rng = np.random.default_rng(0)
    assert simulation.world.planner.kinematics.solve_from_many(far, HOME_JOINTS, rng) is None
