"""When a gripper was opened or closed: from the command where one was recorded, else from how far it is open."""

from __future__ import annotations

import itertools

import numpy as np

from lerobot_llakey.keyframes.motion import Motion

_LEAST_CHANGE = 0.08
"""Share of its travel by which a gripper has to open or close: a finger that gives way moves less."""
_SHORTEST_STATE = 0.25
"""Seconds for which a command stays, else it was a slip of the finger."""
_LONGEST_WAY = 1.2
"""Seconds that the fingers take at most."""
_STILL = 0.03
"""Share of its travel by which a gripper that stands still may differ from where it ends up."""


def gripper_events(motion: Motion) -> list[tuple[int, int]]:
    """Frames at which the gripper begins to open or close, and at which it is done, in order.

    A command that changes and stays says it best, as a gripper that closes on something wide hardly moves. Without one,
    an event is a movement of the fingers that leads far enough away from where they stood still (hysteresis).
    """
    if motion.commanded is not None and np.ptp(motion.commanded.astype(int)):
        return _commanded(motion)
    return _moved(motion)


def _commanded(motion: Motion) -> list[tuple[int, int]]:
    assert motion.commanded is not None
    flips = _debounced(motion.commanded.astype(bool), max(1, round(_SHORTEST_STATE * motion.fps)))
    ends = [*flips, len(motion)][1:]
    return [(flip, _settled(motion, flip, end)) for flip, end in zip(flips, ends, strict=True)]


def _debounced(states: np.ndarray, shortest: int) -> list[int]:
    """First frames of new states that stay for a while."""
    changes = [*(np.flatnonzero(np.diff(states.astype(int))) + 1).tolist(), len(states)]
    flips, now = [], states[0]
    for begin, end in itertools.pairwise(changes):
        if states[begin] != now and (end - begin >= shortest or end == len(states)):
            flips.append(begin)
            now = states[begin]
    return flips


def _settled(motion: Motion, begin: int, end: int) -> int:
    """The first frame at which the fingers are where they stay after a command."""
    last = min(end, begin + max(2, round(_LONGEST_WAY * motion.fps)), len(motion))
    openings = motion.openings[begin:last]
    tail = max(1, round(0.2 * motion.fps))
    limit = _STILL + 4 * _noise(motion.openings)
    # The fingers have arrived where nothing changes any more within a fifth of a second, once they had time to begin.
    for place in range(min(len(openings) - 1, max(1, round(0.1 * motion.fps))), len(openings)):
        ahead = openings[place : place + tail + 1]
        if np.ptp(ahead) <= limit:
            return begin + place
    return last - 1


def _moved(motion: Motion) -> list[tuple[int, int]]:
    """Movements of the opening: from where it leaves a value for good to where it stands still again."""
    openings, least = motion.openings, max(_LEAST_CHANGE, 6 * _noise(motion.openings))
    window, limit = max(1, round(0.2 * motion.fps)), _STILL + 4 * _noise(motion.openings)
    still = np.array([np.ptp(openings[place : place + window + 1]) <= limit for place in range(len(openings))])
    events, level, begin = [], float(openings[0]), None
    for frame in range(1, len(openings)):
        if not still[frame]:
            begin = frame if begin is None else begin
        elif begin is not None:
            here = float(np.median(openings[frame : frame + window + 1]))
            if abs(here - level) >= least:
                events.append((begin, frame))
                level = here
            begin = None
    return events


def _noise(openings: np.ndarray) -> float:
    """Standard deviation of the sensor's noise, from neighbouring frames: most of them stand still."""
    return float(np.median(np.abs(np.diff(openings)))) * 1.4826 / np.sqrt(2)
