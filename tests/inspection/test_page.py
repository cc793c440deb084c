"""The page shows cameras, stages and poses, and says how far off the decision is."""

from dataclasses import replace

import numpy as np
import pytest

from fakes_trace import a_trace
from lerobot_llakey.inspection.page import PREDICTED, TRUE, heatmap_over, page, report


def pixels_of(picture: np.ndarray, colour: tuple[int, int, int]) -> int:
    return int((picture == np.array(colour)).all(axis=-1).sum())


@pytest.mark.parametrize("stages", [1, 2])
def test_each_stage_has_a_row(stages: int) -> None:
    picture = page(a_trace(stages=stages))
    assert picture.dtype == np.uint8
    assert picture.shape[1] == 4 * 240
    assert picture.shape[0] == page(a_trace(stages=0)).shape[0] + stages * 244


def test_more_views_than_cameras_widen_the_page() -> None:
    assert page(a_trace(views=("top", "front", "side", "back", "left"))).shape[1] == 5 * 240


def test_both_poses_are_drawn_in_views_and_in_3d() -> None:
    picture = page(a_trace())
    words, panels = 4 * 28 + 8, slice(-424, None)
    for colour in (PREDICTED, TRUE):
        assert pixels_of(picture[words : words + 244], colour) == 0, "not over the cameras"
        assert pixels_of(picture[words + 244 : panels.start], colour) > 6 * 10, "marks in six views"
        assert pixels_of(picture[panels], colour) > 50


def test_marks_lie_where_the_positions_project() -> None:
    picture = page(a_trace(stages=1, off=0.25))
    top = picture[4 * 28 + 8 + 244 :][:240, :240]
    rows, columns = np.nonzero((top == np.array(PREDICTED)).all(axis=-1))
    assert (rows.mean(), columns.mean()) == pytest.approx((0.5 * 240, 0.75 * 240), abs=2)
    front = picture[4 * 28 + 8 + 244 :][:240, 240:480]
    rows, columns = np.nonzero((front == np.array(TRUE)).all(axis=-1))
    assert (rows.mean(), columns.mean()) == pytest.approx((0.75 * 240, 0.5 * 240), abs=2), "upright: low is below"


def test_the_words_tell_the_errors() -> None:
    task, instruction, errors = report(a_trace())
    assert "open the drawer" in task and "grasp the handle" in instruction
    assert "10.0 cm" in errors and "0.0 degrees" in errors
    assert "gripper right (open, recorded open)" in errors


def test_what_the_command_policy_says_has_a_line_of_its_own() -> None:
    trace = replace(a_trace(), said="close the gripper")
    assert report(trace)[2] == "command policy: close the gripper"
    assert page(trace).shape[0] == page(a_trace()).shape[0] + 28


def test_heat_covers_the_image_where_it_is_hot() -> None:
    image, heatmap = np.full((8, 8, 3), 0.5), np.zeros((8, 8))
    heatmap[2, 3] = 1e-3
    covered = heatmap_over(image, heatmap)
    assert covered[2, 3].tolist() == [255, 255, 255]
    assert (np.delete(covered.reshape(64, 3), 2 * 8 + 3, axis=0) == 127).all()
