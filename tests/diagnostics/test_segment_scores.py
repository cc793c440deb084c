"""The measures of found keyframes."""

import pytest

from lerobot_llakey.diagnostics.segment_scores import f1, matches, segments_matched


def test_a_true_keyframe_counts_once() -> None:
    assert matches([8, 10, 30], [9, 33]) == 2
    assert matches([8, 10], [40]) == 0
    assert matches([], [4]) == 0


def test_the_best_pairing_counts() -> None:
    assert matches([3, 6], [6, 9]) == 2


@pytest.mark.parametrize(("overlap", "right"), [(0.1, 2), (0.25, 2), (0.5, 0)])
def test_segments_are_right_where_they_overlap_enough(overlap: float, right: int) -> None:
    assert segments_matched([6, 20], [14, 20], overlap) == right


def test_a_split_segment_is_right_once() -> None:
    assert segments_matched([10, 20], [20], 0.5) == 1
    assert f1(1, 2, 1) == pytest.approx(2 / 3)
