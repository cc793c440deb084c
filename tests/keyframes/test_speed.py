"""The rule ``speed`` on hands that slow down without stopping."""

import numpy as np
import pytest

from fakes_motions import moving
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.keyframes.speed import speed_keyframes

STRAIGHT = [[0.2, 0, 0.3], [0.4, 0, 0.3], [0.6, 0, 0.3]]


def test_a_hand_that_slows_down_on_a_straight_line_has_a_keyframe_there() -> None:
    found = speed_keyframes(moving(STRAIGHT, slow=True))
    assert len(found) == 2
    assert np.abs(np.subtract(found, [20, 40])).max() <= 2


def test_a_steady_hand_has_none_but_the_last_frame() -> None:
    assert speed_keyframes(moving(STRAIGHT, noise=0.0)) == [40]


def test_the_prominence_must_make_sense() -> None:
    with pytest.raises(LlakeyError, match="speed_prominence"):
        speed_keyframes(moving(STRAIGHT), prominence=0.0)
