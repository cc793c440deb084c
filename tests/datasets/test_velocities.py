import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.datasets.velocities import estimate_velocities, velocity_columns


def test_there_is_one_for_each_further_number_and_then_the_grippers() -> None:
    names, places = velocity_columns(["shoulder.pos", "gripper", *schema.POSE_NAMES, "joint_2"])
    assert names == ["shoulder_velocity", "joint_2_velocity", "gripper_velocity"]
    assert places == [0, 9, 1]
    assert velocity_columns(schema.SIM_STATE_NAMES)[0] == list(schema.SIM_VELOCITY_NAMES)
    assert velocity_columns(schema.POSE_NAMES) == ([], [])


@pytest.mark.parametrize("count", [0, 1, 6])
def test_steady_motion_is_found(count: int) -> None:
    slopes = np.linspace(-0.1, 0.1, count)
    velocities = estimate_velocities((np.arange(5)[:, None] * slopes).astype(np.float32), fps=10)
    assert velocities.shape == (5, count) and velocities.dtype == np.float32
    assert np.allclose(velocities, 10 * slopes, atol=1e-5)


def test_where_a_motion_begins_or_ends_the_robot_stands() -> None:
    velocities = estimate_velocities(np.array([[0.0, 0.0, 0.1, 0.3, 0.3, 0.3]]).T, fps=10)[:, 0]
    assert velocities == pytest.approx([0, 0, 1, 0, 0, 0], abs=1e-5)


def test_what_turns_back_stands_for_a_moment() -> None:
    velocities = estimate_velocities(np.array([[0.0, 0.1, 0.2, 0.1, 0.0]]).T, fps=10)[:, 0]
    assert velocities == pytest.approx([1, 1, 0, -1, -1])
