"""Keyframes that a person chose, and recordings in which a rule finds next to none."""

import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.datasets.found import FoundKeyframes, chosen_keyframes, few_keyframes
from lerobot_llakey.errors import LlakeyError


@pytest.mark.parametrize(
    ("frames", "message"),
    [
        ([3], "the last frame, 9, among"),
        ([], "got none"),
        ([3, 10], "got frame 10"),
        ([0, 9], "got frame 0"),
    ],
)
def test_keyframes_that_do_not_fit_the_episode_are_refused(frames: list[int], message: str) -> None:
    with pytest.raises(LlakeyError, match=message):
        chosen_keyframes(2, frames, 10)


def test_chosen_keyframes_are_put_in_order() -> None:
    assert chosen_keyframes(0, [9, 3], 10) == [3, 9]


def episode(keyframes: list[int]) -> FoundKeyframes:
    return FoundKeyframes(0, "task", np.zeros((10, 8)), schema.HAND_NAMES, np.ones(10, bool), keyframes, 10.0)


def test_a_rule_that_finds_the_last_frame_alone_is_said() -> None:
    assert "in 2 of 3 episodes by rest; try --keyframes=waypoints" in few_keyframes(
        [episode([9]), episode([9]), episode([4, 9])], ["rest"]
    )
    assert few_keyframes([episode([9]), episode([4, 9])], ["rest"]) == ""
