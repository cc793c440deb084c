import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.datasets.velocities import estimate_velocities


def states_of(joint: list[float]) -> np.ndarray:
    """All columns of the state following one course."""
    return np.repeat(np.array(joint, dtype=np.float32)[:, None], schema.STATE_DIM, axis=1)


def test_steady_motion_is_found_in_the_contracts_order() -> None:
    states = np.zeros((5, schema.STATE_DIM), dtype=np.float32)
    states[:, schema.JOINTS.start + 1] = 0.02 * np.arange(5)
    states[:, schema.GRIPPER] = 1 - 0.1 * np.arange(5)
    velocities = estimate_velocities(states, fps=10)
    assert velocities.shape == (5, schema.VELOCITY_DIM) and velocities.dtype == np.float32
    assert np.allclose(velocities[:, 1], 0.2, atol=1e-5) and np.allclose(velocities[:, 7], -1.0, atol=1e-5)
    assert np.allclose(np.delete(velocities, [1, 7], axis=1), 0)


def test_where_a_motion_begins_or_ends_the_robot_stands() -> None:
    velocities = estimate_velocities(states_of([0.0, 0.0, 0.1, 0.3, 0.3, 0.3]), fps=10)[:, 0]
    assert velocities == pytest.approx([0, 0, 1, 0, 0, 0], abs=1e-5)


def test_what_turns_back_stands_for_a_moment() -> None:
    assert estimate_velocities(states_of([0.0, 0.1, 0.2, 0.1, 0.0]), fps=10)[:, 0] == pytest.approx([1, 1, 0, -1, -1])
