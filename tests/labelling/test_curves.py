"""The curves of the time line, on motion whose speed is known."""

import numpy as np

from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.labelling.curves import opening, speed


def test_the_speed_is_the_hands_in_metres_a_second(found: list[FoundKeyframes]) -> None:
    values = speed(found[0])
    assert values.shape == (40,)
    assert np.allclose(values[3:8], 0.2, atol=1e-4) and np.allclose(values[24:36], 0.2, atol=1e-4)
    assert np.allclose(values[13:18], 0.0, atol=1e-4)


def test_the_opening_is_the_grippers(found: list[FoundKeyframes]) -> None:
    values = opening(found[0])
    assert values[:15].tolist() == [1.0] * 15 and values[15:].tolist() == [0.0] * 25
