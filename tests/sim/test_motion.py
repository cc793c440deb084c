"""An executed action ends where it was told, at rest, with the gripper as told."""

import numpy as np

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.sim.world import World


def test_execute_reaches_and_rests(drawer_world: World) -> None:
    drawer_world.reset(1)
    target = Pose(np.array([0.42, 0.15, 0.25]), top_down(0.3))
    drawer_world.motion.execute(target, gripper_open=False, ignore_collision=False)
    distance, angle = drawer_world.tool.distance(target)
    assert distance < 3e-3 and angle < 0.02
    assert drawer_world.gripper_closed and drawer_world.robot.opening(drawer_world.data) < 0.05
    assert np.abs(drawer_world.data.qvel[drawer_world.robot.dofs]).max() < 0.02


def test_joint_speed_stays_within_the_arm(drawer_world: World) -> None:
    drawer_world.reset(1)
    speeds: list[float] = []
    drawer_world.observe(lambda: speeds.append(np.abs(drawer_world.data.qvel[drawer_world.robot.dofs]).max()), 50)
    drawer_world.motion.execute(Pose(np.array([0.5, -0.3, 0.2]), top_down(-0.5)), True, False)
    drawer_world.observe(None)
    assert 0.2 < max(speeds) < 2.17
