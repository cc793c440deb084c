"""An executed action ends where it was told, at rest, with the gripper as told."""

import numpy as np

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.sim.simulation import Simulation


def test_execute_reaches_and_rests(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(1)
    target = Pose(np.array([0.42, 0.15, 0.25]), top_down(0.3))
    simulation.motion.execute(target, gripper_open=False, ignore_collision=False)
    distance, angle = world.tool.distance(target)
    assert distance < 3e-3 and angle < 0.02
    assert world.gripper_closed and world.robot.opening(world.data) < 0.05
    assert np.abs(world.data.qvel[world.robot.dofs]).max() < 0.02


def test_joint_speed_stays_within_the_arm(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(1)
    speeds: list[float] = []
    simulation.clock.observe(lambda: speeds.append(np.abs(world.data.qvel[world.robot.dofs]).max()), 50)
    simulation.motion.execute(Pose(np.array([0.5, -0.3, 0.2]), top_down(-0.5)), True, False)
    simulation.clock.observe(None)
    assert 0.2 < max(speeds) < 2.17
