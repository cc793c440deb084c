"""The arm's model: joints, hand and tool centre point."""

import mujoco
import numpy as np
import pytest

from lerobot_llakey.sim.arm.panda import ARM_JOINTS, HOME_JOINTS, VISUAL_GROUP, Robot, panda_spec


@pytest.fixture(scope="module")
def arm() -> tuple[mujoco.MjModel, mujoco.MjData, Robot]:
    model = panda_spec().compile()
    return model, mujoco.MjData(model), Robot(model)


def test_home_holds_the_hand_above_the_table_pointing_down(arm: tuple) -> None:
    model, data, robot = arm
    robot.set_joints(data, HOME_JOINTS, opening=0.5)
    mujoco.mj_forward(model, data)
    pose = robot.tcp_pose(data)
    assert np.allclose(pose.rotation.as_matrix()[:, 2], (0, 0, -1), atol=1e-2)
    assert 0.3 < pose.position[2] < 0.6
    assert robot.opening(data) == pytest.approx(0.5)
    assert np.allclose(robot.joints(data), HOME_JOINTS)


def test_the_arm_stays_where_it_is_told(arm: tuple) -> None:
    model, data, robot = arm
    mujoco.mj_resetData(model, data)
    robot.set_joints(data, HOME_JOINTS)
    mujoco.mj_step(model, data, 500)
    assert np.abs(robot.joints(data) - HOME_JOINTS).max() < 5e-3


def test_velocities_are_those_of_what_the_state_tells(arm: tuple) -> None:
    model, data, robot = arm
    mujoco.mj_resetData(model, data)
    robot.set_joints(data, HOME_JOINTS, opening=1.0)
    assert np.array_equal(robot.velocity(data), np.zeros(8))
    data.ctrl[robot.actuators[2]] += 0.2
    data.ctrl[robot.finger_actuators] = 0.0
    mujoco.mj_step(model, data, 20)
    before = np.append(robot.joints(data), robot.opening(data))
    mujoco.mj_step(model, data, 1)
    change = (np.append(robot.joints(data), robot.opening(data)) - before) / model.opt.timestep
    assert np.allclose(robot.velocity(data), change, atol=1e-3)
    assert robot.velocity(data)[2] > 0.1 and robot.velocity(data)[7] < -0.1


def test_only_the_detailed_model_carries_visual_meshes(arm: tuple) -> None:
    assert len(ARM_JOINTS) == 7
    assert not (arm[0].geom_group == VISUAL_GROUP).any()
    assert (panda_spec(detailed=True).compile().geom_group == VISUAL_GROUP).any()


def test_no_posture_reaches_farther_than_the_longest_reach(arm: tuple) -> None:
    model, data, robot = arm
    rng, farthest = np.random.default_rng(0), 0.0
    for _ in range(500):
        robot.set_joints(data, rng.uniform(*robot.limits.T))
        mujoco.mj_kinematics(model, data)
        farthest = max(farthest, float(np.linalg.norm(robot.tcp_pose(data).position)))
    assert 0.7 * robot.longest_reach < farthest < robot.longest_reach < 1.5
