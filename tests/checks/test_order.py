"""Rows in order, and the files and episodes that checks of keyframes tell apart."""

import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import EPISODE, FRAME, INDEX, Columns
from lerobot_llakey.checks.order import check_keyframes, check_order, is_dense, is_visited


def columns(**changed: np.ndarray) -> Columns:
    """Two episodes of four frames with a keyframe in the middle and one at the end."""
    frame, one = np.tile(np.arange(4), 2), np.tile([0, 0, 1, 1], 2)
    values = {
        EPISODE: np.arange(8) // 4,
        FRAME: frame,
        INDEX: np.arange(8),
        schema.KEYFRAME_INDEX: one,
        schema.NEXT_KEYFRAME: np.tile([2, 2, 3, 3], 2),
        schema.IS_KEYFRAME: np.tile([False, False, True, True], 2),
    }
    return Columns(values | changed, {})


def test_whole_recordings_are_sound() -> None:
    sound = columns()
    assert is_dense(sound) and not is_visited(sound, slice(0, 4))
    assert [*check_order(sound), *check_keyframes(sound, True)] == []


def test_samples_and_visited_states_are_no_recordings() -> None:
    assert not is_dense(columns(**{schema.NEXT_KEYFRAME: np.tile([20, 20, 30, 30], 2)}))
    visited = columns(
        **{schema.KEYFRAME_INDEX: np.tile(np.arange(4), 2), schema.NEXT_KEYFRAME: np.tile(np.arange(1, 5), 2)}
    )
    assert is_visited(visited, slice(0, 4))


@pytest.mark.parametrize(
    ("key", "values"),
    [
        (FRAME, [0, 1, 3, 2, 0, 1, 2, 3]),
        (INDEX, [0, 1, 1, 3, 4, 5, 6, 7]),
        (EPISODE, [1, 1, 1, 1, 0, 0, 0, 0]),
        (schema.KEYFRAME_INDEX, [0, 1, 0, 1, 0, 0, 1, 1]),
        (schema.NEXT_KEYFRAME, [2, 2, 3, 9, 2, 2, 3, 3]),
        (schema.IS_KEYFRAME, [True, False, True, True, False, False, True, True]),
    ],
)
def test_what_is_out_of_order_is_named(key: str, values: list[int]) -> None:
    wrong = columns(**{key: np.array(values)})
    assert key in {finding.column for finding in (*check_order(wrong), *check_keyframes(wrong, True))}
