"""What the time line draws beside the keyframes: the gripper's opening and the hand's speed."""

from __future__ import annotations

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.hand import hand_columns, read_hand

_SMOOTH_SECONDS = 0.15


def opening(episode: FoundKeyframes) -> np.ndarray:
    """(T,) opening of the gripper, 0..1."""
    return read_hand(episode.states, hand_columns(episode.names))[:, schema.GRIPPER].clip(0.0, 1.0)


def speed(episode: FoundKeyframes) -> np.ndarray:
    """(T,) speed of the hand in m/s, a moving average so that sensor noise does not hide the rests."""
    places = read_hand(episode.states, hand_columns(episode.names))[:, schema.POSITION].astype(np.float64)
    window = min(2 * round(_SMOOTH_SECONDS * episode.fps / 2) + 1, len(places))
    weights = np.ones(window)
    count = np.convolve(np.ones(len(places)), weights, "same")
    smooth = np.stack([np.convolve(axis, weights, "same") / count for axis in (places - places.mean(axis=0)).T], axis=1)
    return np.linalg.norm(np.gradient(smooth, axis=0), axis=1) * episode.fps
