"""Settings within sense."""

import math

import pytest

from lerobot_llakey.bounds import require_count, require_number
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
