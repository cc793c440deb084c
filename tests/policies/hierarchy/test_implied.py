import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.implied import about_tool_axis, set_gripper, straight_up


def _pose(rng: np.random.Generator, length: int) -> np.ndarray:
    values = np.zeros(length)
    values[schema.POSITION] = rng.uniform(-0.5, 0.5, 3)
    values[schema.QUATERNION] = Rotation.random(random_state=int(rng.integers(2**31))).as_quat()
    values[schema.GRIPPER] = 1.0
    return values


def test_a_screw_turns_about_and_goes_along_the_tool_axis_only() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        state, action = _pose(rng, 15), _pose(rng, 9)
        changed = about_tool_axis(action, state)
        present, after = (Rotation.from_quat(pose[schema.QUATERNION]) for pose in (state, changed))
        axis = present.as_matrix()[:, 2]
        assert np.allclose(after.as_matrix()[:, 2], axis)
        moved = changed[schema.POSITION] - state[schema.POSITION]
        assert np.allclose(np.cross(moved, axis), 0)
        assert axis @ moved == pytest.approx(axis @ (action[schema.POSITION] - state[schema.POSITION]))


def test_a_screw_that_is_one_already_stays_as_it_is() -> None:
    rng = np.random.default_rng(1)
    for degrees in (-120, 5, 110, 180):
        state, action = _pose(rng, 15), np.zeros(9)
        present = Rotation.from_quat(state[schema.QUATERNION])
        action[schema.POSITION] = state[schema.POSITION] + 0.01 * present.as_matrix()[:, 2]
        action[schema.QUATERNION] = (present * Rotation.from_euler("z", degrees, degrees=True)).as_quat()
        changed = about_tool_axis(action, state)
        assert np.allclose(changed[schema.POSITION], action[schema.POSITION])
        assert abs(changed[schema.QUATERNION] @ action[schema.QUATERNION]) == pytest.approx(1.0)


def test_half_a_turn_about_another_axis_has_no_screw_in_it() -> None:
    state, action = np.zeros(15), np.zeros(9)
    state[schema.QUATERNION] = 0, 0, 0, 1
    action[schema.QUATERNION] = 1, 0, 0, 0
    assert np.allclose(about_tool_axis(action, state)[schema.QUATERNION], state[schema.QUATERNION])


@pytest.mark.parametrize(("height", "expected"), [(0.5, 0.5), (0.1, 0.3)])
def test_raising_goes_straight_up(height: float, expected: float) -> None:
    state, action = np.zeros(15), np.zeros(9)
    state[schema.POSITION] = 0.4, -0.1, 0.3
    action[:7] = 0.6, 0.2, height, 0, 0, 1, 0
    changed = straight_up(action, state)
    assert np.allclose(changed[schema.POSITION], [0.4, -0.1, expected])
    assert np.array_equal(changed[schema.QUATERNION], action[schema.QUATERNION])


def test_grasping_closes_and_releasing_opens() -> None:
    action = np.full(9, 0.5)
    assert set_gripper(action, False)[schema.GRIPPER] == 0.0
    assert set_gripper(action, True)[schema.GRIPPER] == 1.0
    assert np.array_equal(set_gripper(action, None), action)
