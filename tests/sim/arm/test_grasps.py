"""The hand that brings a thing somewhere upright, however the thing sits in it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.sim.arm.grasps import MOST_TILT, Grasp, hand_yaw


def test_an_upright_thing_is_brought_by_an_upright_hand() -> None:
    hand = Grasp.upright(0.06).hand(np.array((0.5, 0.1, 0.2)), 0.9)
    assert np.allclose(hand.position, (0.5, 0.1, 0.26))
    assert hand.distance(Pose(hand.position, top_down(0.9)))[1] < 1e-6


@pytest.mark.parametrize("lean", [(0.3, 0.0, 0.0), (0.0, -0.25, 0.4), (0.2, 0.2, -1.0)])
def test_a_hand_leans_to_set_a_tilted_thing_upright(lean: tuple[float, float, float]) -> None:
    tool = Pose(np.array((0.4, 0.0, 0.2)), top_down(0.5))
    thing = Pose(np.array((0.41, -0.01, 0.14)), Rotation.from_rotvec(lean).as_quat())
    grip, place = Grasp.of(tool, thing), np.array((0.5, 0.2, 0.1))
    brought = grip.hand(place, -0.7) @ (tool.inverse() @ thing)
    assert np.allclose(brought.position, place)
    assert brought.rotation.as_matrix()[2, 2] == pytest.approx(1.0)
    assert grip.tilt == pytest.approx(np.arccos(thing.rotation.as_matrix()[2, 2]))


def test_a_hand_leans_no_farther_than_it_can() -> None:
    grip = Grasp(np.array((0.0, 0.0, 0.06)), np.array((1.0, 0.0, 0.0)))
    hand = grip.hand(np.zeros(3), 0.0)
    assert hand.rotation.as_matrix()[2, 2] == pytest.approx(-np.cos(MOST_TILT))


@pytest.mark.parametrize("yaw", [-1.5, -0.9, 0.0, 0.9, 1.5])
def test_yaw_of_a_hand_that_points_down(yaw: float) -> None:
    assert hand_yaw(Pose(np.zeros(3), top_down(yaw))) == pytest.approx(yaw)
    assert hand_yaw(Pose(np.zeros(3), top_down(yaw + np.pi))) == pytest.approx(yaw)
