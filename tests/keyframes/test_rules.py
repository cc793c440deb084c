"""A choice of rules, and what becomes of keyframes that two of them found."""

import numpy as np
import pytest

from fakes_motions import moving
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.keyframes.rules import RuleSettings, find_by_rules, parse_rules

CORNERS = [[0.3, 0, 0.3], [0.3, 0, 0.1], [0.5, 0, 0.1]]


def test_rules_are_joined_by_a_plus_sign() -> None:
    assert parse_rules("rest + waypoints") == ("rest", "waypoints")


@pytest.mark.parametrize("text", ["", "rests", "rest+rest", "rest,waypoints", "rest+"])
def test_unknown_rules_are_refused(text: str) -> None:
    with pytest.raises(LlakeyError, match="--keyframes as rest, waypoints, speed"):
        parse_rules(text)


def test_what_two_rules_found_is_one_keyframe() -> None:
    motion = moving(CORNERS, slow=True)
    found = find_by_rules(motion, ("waypoints", "speed"))
    assert len(found) == 2
    assert abs(found[0] - 20) <= 2


def test_rest_finds_the_last_frame_alone_where_nothing_rests() -> None:
    assert find_by_rules(moving(CORNERS), ("rest",)) == [40]


def test_the_last_frame_stands_for_a_gripper_that_has_just_opened_there() -> None:
    still = moving([*CORNERS[:2], CORNERS[1]], grips=[(28, 0.0)])
    assert find_by_rules(still, ("waypoints",))[-1] == 40
    assert not [frame for frame in find_by_rules(still, ("waypoints",)) if 28 <= frame < 40]


def test_merging_within_no_time_keeps_distinct_keyframes() -> None:
    motion = moving(CORNERS)
    assert len(find_by_rules(motion, ("waypoints",), RuleSettings(merge=0.0))) == 2
    assert np.diff(find_by_rules(motion, ("waypoints", "speed"))).min() > 6
