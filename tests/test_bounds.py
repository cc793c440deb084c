"""Settings within sense."""

import math
from types import SimpleNamespace

import pytest

from lerobot_llakey.bounds import (
    Bounds,
    require_box,
    require_count,
    require_number,
    require_settings,
    require_texts,
)
from lerobot_llakey.errors import LlakeyError


@pytest.mark.parametrize("value", [math.nan, math.inf, -0.1, 1.1, True, "0.5", None])
def test_a_share_is_a_finite_number_between_0_and_1(value: float) -> None:
    with pytest.raises(LlakeyError, match=r"Expected --recovery to be a number from 0 to 1, got .*; correct it\."):
        require_number("--recovery", value, 0, 1)
    require_number("--recovery", 0, 0, 1)
    require_number("--recovery", 1.0, 0, 1)


def test_bounds_may_be_left_out_or_be_open() -> None:
    require_number("x", 1e300)
    require_number("x", 1e-9, 0, 1, open="low high")
    for value, said in ((0.0, "above 0 and below 1"), (1.0, "above 0 and below 1")):
        with pytest.raises(LlakeyError, match=said):
            require_number("x", value, 0, 1, open="low high")
    with pytest.raises(LlakeyError, match="above 0, got 0"):
        require_number("x", 0, 0, open="low")
    with pytest.raises(LlakeyError, match="finite, got inf"):
        require_number("x", math.inf)


@pytest.mark.parametrize("value", [-1, 1.5, True, 11])
def test_a_count_is_a_whole_number_within_its_bounds(value: int) -> None:
    with pytest.raises(LlakeyError, match=r"Expected --num_workers to be a whole number from 0 to 10, got"):
        require_count("--num_workers", value, 0, 10)
    require_count("--num_workers", 0, 0, 10)


def test_settings_are_held_against_a_table() -> None:
    table = {
        "share": Bounds(0, 1),
        "sizes": Bounds(1, whole=True, length=2),
        "rate": Bounds(0, open="low", optional=True),
    }
    require_settings(SimpleNamespace(share=0.5, sizes=[1, 2], rate=None), table)
    for change, said in (
        ({"share": math.nan}, "share to be a number from 0 to 1, got nan"),
        ({"sizes": [1, 0]}, r"sizes\[1\] to be a whole number of 1 or more, got 0"),
        ({"sizes": [1]}, r"sizes as a list of 2 numbers, got \[1\]"),
        ({"sizes": 3}, "sizes as a list of 2 numbers, got 3"),
        ({"rate": 0.0}, "rate to be a number above 0, got 0.0"),
    ):
        with pytest.raises(LlakeyError, match=said):
            require_settings(SimpleNamespace(**({"share": 0.5, "sizes": [1, 2], "rate": 1.0} | change)), table)


def test_a_list_of_texts_names_each_once() -> None:
    require_texts("cameras", ["front", "wrist"], some=True)
    for texts, said in (
        (["front", "front"], "each of cameras once, got 'front' more than once"),
        (["front", ""], "cameras as a list of texts"),
        ("front", "cameras as a list of texts, got 'front'"),
        ([], "cameras to name at least one"),
    ):
        with pytest.raises(LlakeyError, match=said):
            require_texts("cameras", texts, some=True)


def test_a_box_is_three_pairs_that_rise() -> None:
    require_box("workspace", [[0, 1], [-0.5, 0.5], (0, 1)], 10)
    for box, said in (
        ([[0, 1], [0, 1]], "three"),
        ([[0, 1], [1, 1], [0, 1]], "got y from 1 to 1"),
        ([[0, 1], [0, 1], [0, 11]], r"workspace \(z\) to be a number from -10 to 10, got 11"),
        (7, "three"),
    ):
        with pytest.raises(LlakeyError, match=said):
            require_box("workspace", box, 10)  # type: ignore[arg-type]
