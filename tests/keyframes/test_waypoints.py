"""The rule ``waypoints`` on hands that never rest."""

import numpy as np
import pytest

from fakes_motions import moving
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.keyframes.waypoints import simplify, waypoint_keyframes

CORNERS = [[0.3, 0, 0.3], [0.3, 0, 0.1], [0.5, 0, 0.1], [0.5, 0.2, 0.1]]


@pytest.mark.parametrize("fps", [10.0, 20.0, 30.0])
@pytest.mark.parametrize("noise", [0.0, 0.001, 0.002])
def test_corners_are_found_where_the_hand_turns(fps: float, noise: float) -> None:
    frames = round(fps)
    found = waypoint_keyframes(moving(CORNERS, frames=frames, fps=fps, noise=noise))
    assert len(found) == 3
    assert np.abs(np.subtract(found, [frames, 2 * frames, 3 * frames])).max() <= 2


def test_a_hand_that_turns_far_about_one_axis_goes_straight() -> None:
    motion = moving([[0.3, 0, 0.3], [0.3, 0, 0.1], [0.3, 0, 0.1]], [0, 0, 3.0])
    found = waypoint_keyframes(motion)
    assert len(found) == 2
    assert abs(found[0] - 20) <= 2


def test_a_gripper_that_closes_on_a_straight_way_is_a_keyframe() -> None:
    motion = moving([[0.3, 0, 0.3], [0.3, 0, 0.1]], frames=60, grips=[(30, 0.0)])
    assert [frame for frame in waypoint_keyframes(motion) if 30 <= frame <= 36]


def test_a_blunt_corner_counts_where_the_hand_slows_down() -> None:
    bent = [[0.2, 0, 0.3], [0.5, 0, 0.3], [0.8, 0.15, 0.3]]
    assert waypoint_keyframes(moving(bent, noise=0.0)) == [40]
    slowed = waypoint_keyframes(moving(bent, noise=0.0, slow=True))
    assert len(slowed) == 2
    assert abs(slowed[0] - 20) <= 1


def test_there_and_back_again_has_a_corner() -> None:
    path = np.abs(np.linspace(-5, 5, 21))[:, None]
    assert simplify(path, 0, 20) == [0, 10, 20]


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
def test_a_tolerance_must_make_sense(value: float) -> None:
    with pytest.raises(LlakeyError, match="path_tolerance"):
        waypoint_keyframes(moving(CORNERS), position_tolerance=value)
    with pytest.raises(LlakeyError, match="turn_tolerance"):
        waypoint_keyframes(moving(CORNERS), rotation_tolerance=value)
