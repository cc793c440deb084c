"""Two made-up episodes of one task: the hand moves, rests, closes, rests, moves on."""

from __future__ import annotations

import numpy as np

from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.schema import POSE_NAMES

LENGTH = 40
KEYFRAMES = [10, 20, 39]


def made_up(episode: int, task: str = "lift the cup") -> FoundKeyframes:
    states = np.zeros((LENGTH, 8), dtype=np.float32)
    states[:, 0] = np.interp(np.arange(LENGTH), (0, 10, 20, 39), (0.0, 0.2, 0.2, 0.58))
    states[:, 6] = 1.0
    states[:, 7] = np.arange(LENGTH) < 15
    names = (*POSE_NAMES, "gripper")
    return FoundKeyframes(episode, task, states, names, states[:, 7] > 0.5, list(KEYFRAMES), 10.0)


def three_episodes() -> list[FoundKeyframes]:
    """Two episodes of one task and one of another."""
    return [made_up(0), made_up(1), made_up(2, "open the drawer")]
