import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lerobot_llakey import schema
from lerobot_llakey.geometry import top_down
from lerobot_llakey.policies.command.pose_text import PoseText

share = st.floats(0.001, 0.999)


def action(place: tuple[float, float, float], rotation: Rotation, gripper: int, collision: int) -> np.ndarray:
    low, high = np.array(schema.WORKSPACE).T
    return np.array([*(low + np.array(place) * (high - low)), *rotation.as_quat(), gripper, collision])


@given(st.tuples(share, share, share), st.integers(0, 10_000), st.booleans(), st.booleans(), st.sampled_from([64, 256]))
def test_a_pose_comes_back_within_half_a_bin(place, seed, gripper, collision, bins):
    text, rotation = PoseText(bins), Rotation.random(rng=seed)
    pose = action(place, rotation, gripper, collision)
    again = text.decode(text.encode(pose))
    assert np.abs(again[schema.POSITION] - pose[schema.POSITION]).max() <= 0.5 / bins + 1e-6
    # Each entry of the quaternion is within half of its bin of 2 / bins; an angle is twice the arc that they span.
    error = (Rotation.from_quat(again[schema.QUATERNION]).inv() * rotation).magnitude()
    assert error <= 2 * np.sqrt(4) * 1.0 / bins * 1.3
    assert again[schema.GRIPPER] == gripper and again[schema.IGNORE_COLLISION] == collision
    assert text.encode(again) == text.encode(text.decode(text.encode(again)))


def test_hands_that_point_down_do_not_jump():
    text = PoseText()
    numbers = [
        [int(word) for word in text.encode(action((0.5, 0.5, 0.5), Rotation.from_quat(top_down(yaw)), 1, 0)).split()]
        for yaw in np.linspace(-1.2, 1.2, 200)
    ]
    assert np.abs(np.diff(np.array(numbers)[:, 3:7], axis=0)).max() <= 2


def test_a_state_is_told_as_the_pose_of_an_action_and_the_opening():
    text = PoseText(100)
    pose = action((0.2, 0.4, 0.6), Rotation.random(rng=0), 1, 1)
    for opening, number in ((0.0, "000"), (0.625, "062"), (1.0, "099")):
        state = np.array([*pose[:7], opening, *np.linspace(-2, 2, 7)])
        assert text.encode_hand(state).split() == [*text.encode(pose).split()[:7], number]


def test_places_outside_go_to_the_edge():
    text = PoseText(10, ((0.0, 1.0), (0.0, 1.0), (0.0, 1.0)))
    assert text.encode(np.array([-3, 0.55, 7, 1, 0, 0, 0, 1, 1])).split()[:3] == ["000", "005", "009"]


@pytest.mark.parametrize("text", ["", "1 2 3", "000 " * 8 + "002", "900 " + "000 " * 8, "grasp the red block", "0" * 9])
def test_texts_that_are_no_pose_are_refused(text):
    with pytest.raises(ValueError, match="Expected 9 numbers"):
        PoseText().decode(text)


@pytest.mark.parametrize(("settings", "name"), [({"bins": 1}, "action_bins"), ({"bins": 1001}, "action_bins")])
def test_bins_that_three_digits_cannot_write_are_refused(settings, name):
    with pytest.raises(ValueError, match=name):
        PoseText(**settings)


def test_a_workspace_upside_down_is_refused():
    with pytest.raises(ValueError, match="workspace"):
        PoseText(workspace=((1, 0), (0, 1), (0, 1)))
