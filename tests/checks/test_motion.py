"""Hands that jump, flip or stand still are told; those that move as hands do are not."""

from collections.abc import Callable

import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import EPISODE, FRAME, Columns
from lerobot_llakey.checks.motion import check_motion, moved


def moving() -> np.ndarray:
    """Thirty frames of a hand (8,) that goes 2 cm a frame and turns by 3 degrees about z."""
    half = np.deg2rad(1.5) * np.arange(30)
    hand = np.zeros((30, schema.HAND_DIM))
    hand[:, 0], hand[:, 2] = 0.02 * np.arange(30), 0.3
    hand[:, 5], hand[:, 6] = np.sin(half), np.cos(half)
    return hand


def said(hand: np.ndarray, dense: bool = True) -> list[str]:
    rows = np.arange(len(hand))
    columns = Columns({EPISODE: rows // 15, FRAME: rows % 15, schema.STATE: hand}, {}, hand, hand[:, 8:])
    return [finding.expected for finding in check_motion(columns, dense)]


def test_a_hand_that_moves_is_sound() -> None:
    assert said(moving()) == []


def flip(hand: np.ndarray) -> None:
    hand[5:9, schema.QUATERNION] *= -1


def spike(hand: np.ndarray) -> None:
    hand[7, 1] += 0.2


def twist(hand: np.ndarray) -> None:
    hand[7, schema.QUATERNION] = [1, 0, 0, 0]


def stand(hand: np.ndarray) -> None:
    hand[:15] = hand[0]


@pytest.mark.parametrize(
    ("spoil", "expected"),
    [(flip, "sign"), (spike, "steadily"), (twist, "steadily"), (stand, "in which the hand moves")],
)
def test_one_that_does_not_is_told(spoil: Callable[[np.ndarray], None], expected: str) -> None:
    hand = moving()
    spoil(hand)
    found = said(hand)
    assert len(found) == 1 and expected in found[0]


def test_samples_may_lie_far_apart() -> None:
    hand = moving()
    spike(hand)
    assert said(hand, dense=False) == []


def test_the_sign_of_a_quaternion_is_no_turn() -> None:
    hand = moving()
    apart, turn = moved(hand, np.concatenate((hand[:, :3], -hand[:, 3:7], hand[:, 7:]), axis=1))
    assert apart.max() == 0
    assert turn.max() < 1e-3
