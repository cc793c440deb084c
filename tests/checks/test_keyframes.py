"""Keyframes that miss the gripper's signal, or that are the one before again."""

from collections.abc import Callable

import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import EPISODE, FRAME, Columns
from lerobot_llakey.checks.keyframes import check_gripper, check_segments_actions, check_spacing
from lerobot_llakey.labels import label

KEYFRAMES = [9, 19, 29]


def recording(keyframes: list[int] = KEYFRAMES) -> Columns:
    """Thirty frames: down, closing at frame 19 within two frames, and up again."""
    hand = np.zeros((30, schema.HAND_DIM), dtype=np.float32)
    down, up = [*np.linspace(0.5, 0.3, 10), *np.linspace(0.29, 0.1, 8), 0.1, 0.1], np.linspace(0.13, 0.4, 10)
    hand[:, 2] = [*down, *up]
    hand[:, 6], hand[:, 7] = 1, 1
    hand[18, 7], hand[19:, 7] = 0.5, 0
    count, opened = len(keyframes), (hand[keyframes, 7] > 0.5).tolist()
    made = label(hand, keyframes, ["raise the robotic arm"] * count, [False] * count, opened)
    values = {
        EPISODE: np.zeros(30, dtype=int),
        FRAME: np.arange(30),
        schema.ACTION: made.action,
        schema.KEYFRAME_INDEX: made.keyframe_index,
        schema.NEXT_KEYFRAME: made.next_frame,
        schema.IS_KEYFRAME: made.is_keyframe,
        schema.EPISODE_EVENT: np.array(made.event, dtype=object),
    }
    return Columns(values, {}, hand, hand[:, 8:])


def said(columns: Columns) -> list[str]:
    checks = (check_segments_actions(columns), check_spacing(columns), check_gripper(columns, True))
    return [finding.expected for findings in checks for finding in findings]


def test_keyframes_where_the_gripper_closes_are_sound() -> None:
    assert said(recording()) == []


def test_a_closing_without_a_keyframe_is_told() -> None:
    assert [text for text in said(recording([9, 29])) if "wherever the gripper" in text]


def test_a_keyframe_just_before_another_is_told() -> None:
    assert [text for text in said(recording([9, 19, 28, 29])) if "differ" in text] == []
    columns = recording([8, 9, 19, 29])
    columns.hand[8, 2] = columns.hand[9, 2] + 0.001
    columns[schema.ACTION][:8, 2] = columns.hand[8, 2]
    assert [text for text in said(columns) if "differ" in text]


def open_again(columns: Columns) -> None:
    columns.hand[24, 7] = 1


def unlike(columns: Columns) -> None:
    columns[schema.ACTION][3, 0] += 0.01


@pytest.mark.parametrize(("spoil", "expected"), [(open_again, "wherever the gripper"), (unlike, "one action for all")])
def test_what_is_spoilt_is_told(spoil: Callable[[Columns], None], expected: str) -> None:
    columns = recording()
    spoil(columns)
    [text] = said(columns)
    assert expected in text


def test_what_an_event_does_to_the_gripper_is_left_out() -> None:
    columns = recording()
    open_again(columns)
    columns[schema.EPISODE_EVENT][22:] = "drop"
    assert said(columns) == []
