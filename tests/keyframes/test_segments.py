"""The segments between keyframes."""

import pytest

from lerobot_llakey.keyframes.segments import segments


def test_segments_start_at_keyframes_and_name_the_next_one() -> None:
    result = segments([2, 5], 6)
    assert result.index.tolist() == [0, 0, 1, 1, 1, 1]
    assert result.next_frame.tolist() == [2, 2, 5, 5, 5, 5]
    assert result.is_keyframe.tolist() == [False, False, True, False, False, True]


@pytest.mark.parametrize("keyframes", [[], [0, 5], [2, 2, 5], [2, 4], [2, 6]])
def test_segments_refuse_what_is_no_list_of_keyframes(keyframes: list[int]) -> None:
    with pytest.raises(ValueError, match="end at the last frame 5"):
        segments(keyframes, 6)
