from pathlib import Path

import numpy as np
import PIL.Image
import pytest

from lerobot_llakey.evaluation.abilities.measure import ABILITIES, Measured
from lerobot_llakey.evaluation.abilities.plots import plot_abilities, plot_verbs, verb_matrix


@pytest.fixture
def measured() -> Measured:
    measured = Measured()
    for answer in ("grasp the cup", "grasp the cup", "release the cup"):
        measured.add(ABILITIES[0], "move_cup", "", "grasp the cup", answer)
    return measured


def test_rows_of_the_matrix_are_what_was_expected(measured):
    matrix = verb_matrix(measured.total(ABILITIES[0]), ["grasp", "release"])
    np.testing.assert_array_equal(matrix, [[2, 1], [0, 0]])


@pytest.mark.parametrize("plot", [plot_abilities, plot_verbs])
def test_plots_show_something_even_where_one_ability_was_not_asked_for(plot, measured, tmp_path: Path):
    plot(measured, tmp_path / "plot.png")
    pixels = np.asarray(PIL.Image.open(tmp_path / "plot.png").convert("RGB"))
    assert min(pixels.shape[:2]) > 200 and len(np.unique(pixels.reshape(-1, 3), axis=0)) > 20
