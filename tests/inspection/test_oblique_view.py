"""The oblique view shows what is nearest, upright, and hands where they are."""

import numpy as np
import pytest

from lerobot_llakey import geometry
from lerobot_llakey.inspection.oblique_view import ObliqueView, gripper_lines

CENTRE = np.array([0.5, 0.0, 0.1])


def action(position: np.ndarray, gripper: float = 1.0, yaw: float = 0.0) -> np.ndarray:
    return np.concatenate((position, geometry.top_down(yaw), [gripper, 0.0]))


def test_the_centre_is_in_the_middle_and_up_is_up() -> None:
    view = ObliqueView(CENTRE, 1.0, 200, 100, azimuth=30.0, elevation=40.0)
    assert view.project(CENTRE) == pytest.approx([100, 50, 0])
    column, row, _ = view.project(CENTRE + [0, 0, 0.1])
    assert column == pytest.approx(100)
    assert row == pytest.approx(50 - 10 * np.cos(np.radians(40.0)))


def test_from_straight_ahead_left_of_the_base_is_right() -> None:
    view = ObliqueView(CENTRE, 1.0, 100, 100, azimuth=0.0, elevation=0.0)
    assert view.project(CENTRE + [0, 0.2, 0]) == pytest.approx([70, 50, 0])
    assert view.project(CENTRE + [0.2, 0, 0])[2] < 0, "what is farther ahead of the base is nearer to the camera"


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_the_nearer_point_covers_the_farther(order: list[int]) -> None:
    points = np.array([CENTRE, CENTRE + [0.2, 0, 0]])[order]
    colours = np.array([[1.0, 0, 0], [0, 1.0, 0]])[order]
    picture = ObliqueView(CENTRE, 1.0, 40, 40, azimuth=0.0, elevation=0.0).draw_cloud(points, colours, size=3)
    assert picture[20:23, 20:23].reshape(-1, 3).tolist() == [[0, 255, 0]] * 9


def test_points_beyond_the_picture_are_left_out() -> None:
    far = np.array([CENTRE + [0, 5.0, 0], CENTRE - [0, 5.0, 0], CENTRE + [0, 0, 5.0]])
    picture = ObliqueView(CENTRE, 1.0, 40, 30).draw_cloud(far, np.ones((3, 3)))
    assert picture.max() < 50


def test_an_open_hand_is_wider_and_its_stem_points_back() -> None:
    for gripper, width in ((1.0, 0.08), (0.0, 0.02)):
        fingers, stem = gripper_lines(action(CENTRE, gripper))
        assert np.linalg.norm(fingers[0] - fingers[-1]) == pytest.approx(width)
        assert (fingers[0] + fingers[-1]) / 2 == pytest.approx(CENTRE), "the tool point lies between the fingertips"
        assert stem[-1][2] > stem[0][2] > CENTRE[2], "the hand points down"
    turned, _ = gripper_lines(action(CENTRE, yaw=np.pi / 2))
    assert abs(turned[0] - turned[-1])[0] == pytest.approx(0.08)


def test_a_hand_is_drawn_where_it_is() -> None:
    view = ObliqueView(CENTRE, 0.5, 100, 100)
    picture = np.zeros((100, 100, 3), dtype=np.uint8)
    view.draw_gripper(picture, action(CENTRE), (255, 150, 30))
    assert picture[50, 50].tolist() == [255, 150, 30]
    assert not picture[90:].any()
