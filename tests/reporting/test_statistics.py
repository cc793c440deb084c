"""The trimmed mean, the spread and the intervals, against figures worked out by hand."""

import pytest

from lerobot_llakey.reporting.statistics import kept, spread, trimmed_mean, wilson


def test_best_and_worst_of_six_repeats_are_dropped() -> None:
    repeats = [0.96, 0.80, 0.92, 0.20, 0.84, 0.88]
    assert kept(repeats) == [0.80, 0.84, 0.88, 0.92]
    assert trimmed_mean(repeats) == pytest.approx(0.86)
    assert spread(repeats) == pytest.approx(0.0516398, abs=1e-6)


def test_one_of_several_equal_extremes_is_dropped() -> None:
    assert kept([1.0, 1.0, 0.5, 0.0]) == [0.5, 1.0]


def test_few_repeats_all_count() -> None:
    assert trimmed_mean([0.0, 1.0]) == 0.5 and spread([0.0, 1.0]) == pytest.approx(0.7071, abs=1e-4)
    assert trimmed_mean([0.4]) == 0.4 and spread([0.4]) == 0.0
    with pytest.raises(ValueError, match="at least one repeat"):
        trimmed_mean([])


def test_wilson_interval() -> None:
    low, high = wilson(8, 10)
    assert low == pytest.approx(0.4902, abs=1e-4) and high == pytest.approx(0.9433, abs=1e-4)
    assert wilson(0, 10)[0] == pytest.approx(0.0) and wilson(10, 10)[1] == pytest.approx(1.0)
    assert wilson(0, 0) == (0.0, 1.0)
    assert wilson(500, 1000)[1] - wilson(500, 1000)[0] < 0.07
