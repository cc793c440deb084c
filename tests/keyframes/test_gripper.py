"""When a gripper was opened or closed."""

import numpy as np
import pytest

from fakes_motions import moving
from lerobot_llakey.keyframes.gripper import gripper_events
from lerobot_llakey.keyframes.motion import Motion

STRAIGHT = [[0.3, 0, 0.3], [0.3, 0, 0.1]]


@pytest.mark.parametrize("commanded", [True, False])
def test_closing_and_opening_are_events_that_end_when_the_fingers_stand_still(commanded: bool) -> None:
    motion = moving(STRAIGHT, frames=80, grips=[(20, 0.2), (50, 1.0)], commanded=commanded)
    events = gripper_events(motion)
    assert len(events) == 2
    assert all(20 + 30 * place - 4 <= begin <= 22 + 30 * place for place, (begin, _) in enumerate(events))
    assert all(22 + 30 * place <= end <= 25 + 30 * place for place, (_, end) in enumerate(events))


def test_a_command_that_slips_for_a_moment_is_no_event() -> None:
    motion = moving(STRAIGHT, frames=80)
    commanded = np.ones(81, dtype=bool)
    commanded[30:32] = False
    assert gripper_events(Motion(motion.poses, motion.openings, motion.fps, None, commanded)) == []


def test_a_command_counts_where_the_fingers_hardly_move() -> None:
    motion = moving(STRAIGHT, frames=80)
    assert len(gripper_events(Motion(motion.poses, motion.openings, motion.fps, None, np.arange(81) < 40))) == 1


def test_noise_of_the_opening_is_no_event() -> None:
    motion = moving(STRAIGHT, frames=80)
    openings = np.clip(0.9 + np.random.default_rng(0).normal(0, 0.02, 81), 0, 1)
    assert gripper_events(Motion(motion.poses, openings, motion.fps)) == []
