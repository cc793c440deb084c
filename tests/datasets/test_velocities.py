import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.datasets.velocities import estimate_velocities


def test_steady_motion_is_found_in_the_contracts_order() -> None:
    states = np.zeros((5, schema.STATE_DIM), dtype=np.float32)
    states[:, schema.JOINTS.start + 1] = 0.02 * np.arange(5)
    states[:, schema.GRIPPER] = 1 - 0.1 * np.arange(5)
    velocities = estimate_velocities(states, fps=10)
    assert velocities.shape == (5, schema.VELOCITY_DIM) and velocities.dtype == np.float32
    assert np.allclose(velocities[:, 1], 0.2, atol=1e-5) and np.allclose(velocities[:, 7], -1.0, atol=1e-5)
    assert np.allclose(np.delete(velocities, [1, 7], axis=1), 0)


def test_what_rests_has_no_velocity() -> None:
    states = np.repeat(np.array([0.0, 0.1, 0.1, 0.1, 0.1])[:, None], schema.STATE_DIM, axis=1)
    fastest = np.abs(estimate_velocities(states, fps=10)).max(axis=1)
    assert (fastest[:2] > 0.4).all() and (fastest[2:] < 1e-6).all()
