"""The rule ``waypoints``: where the gripper opens or closes, and where the hand's path has its corners.

Needs no rest: the corners are those of the polyline that Douglas and Peucker (1973) simplify the path to, between one
event of the gripper and the next. Automatic waypoint extraction (AWE; Shi, Sharma, Zhao and Finn 2023) asks for the
fewest waypoints from which the path is got back to within an error; which of many equal answers it gives is chance, so
here the corners are then moved to where the polyline fits best, and from there to where the hand is slowest: people
slow down where they turn to the next goal (the two-thirds power law of Lacquaniti, Terzuolo and Viviani 1983). A blunt
corner at which the hand keeps its speed belongs to a curve, or a way around something.
"""

from __future__ import annotations

import itertools

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.bounds import require_number
from lerobot_llakey.keyframes.gripper import gripper_events
from lerobot_llakey.keyframes.motion import Motion, smoothed

_SMOOTH_SECONDS = 0.4
_FITTING_ROUNDS = 4
_SLOW_SECONDS = 0.2
"""How far from a corner of the fitted polyline the hand may be slowest."""
_SLOWER, _SHARP = 0.2, 60.0
"""The share by which the hand slows down at a corner at least, unless it turns by so many degrees."""


def waypoint_keyframes(
    motion: Motion, *, position_tolerance: float = 0.015, rotation_tolerance: float = 7.5
) -> list[int]:
    """Frames at which the gripper has opened or closed, and corners of the hand's path between them.

    Args:
        motion: one episode.
        position_tolerance: metres by which the polyline may miss the path.
        rotation_tolerance: degrees by which it may miss the hand's rotation.

    Returns:
        Increasing frame indices; the last one is T - 1.

    Raises:
        LlakeyError: if a tolerance makes no sense.
    """
    require_number("path_tolerance", position_tolerance, 0, 1, open="low")
    require_number("turn_tolerance", rotation_tolerance, 0, 180, open="low")
    path = hand_path(motion, position_tolerance, rotation_tolerance)
    last = len(motion) - 1
    events = gripper_frames(motion, path)
    bounds = [0, *(frame for frame in events if 0 < frame < last), last]
    speeds = np.linalg.norm(np.gradient(path, axis=0), axis=1)
    corners, reach = list[int](), round(_SLOW_SECONDS * motion.fps)
    for begin, end in itertools.pairwise(bounds):
        fitted = _fitted(path, simplify(path, begin, end))
        slowest = {_slowest(speeds, corner, begin, end, reach) for corner in fitted[1:-1]}
        corners += _kept(path, speeds, [begin, *sorted(slowest), end])[1:]
    return corners


def hand_path(motion: Motion, position_tolerance: float, rotation_tolerance: float) -> np.ndarray:
    """The smoothed path (T, 6) of the hand: its position, and its turns added up, in units of the tolerances.

    Small turns from frame to frame are added up as vectors, so that a hand that turns about one axis, however far, goes
    straight.

    Args:
        motion: one episode.
        position_tolerance: metres.
        rotation_tolerance: degrees.
    """
    quiet = smoothed(motion.poses, motion.fps, _SMOOTH_SECONDS)
    turned = Rotation.from_quat(quiet[:, 3:])
    turns = np.concatenate((np.zeros((1, 3)), (turned[1:] * turned[:-1].inv()).as_rotvec())).cumsum(axis=0)
    return np.concatenate((quiet[:, :3] / position_tolerance, turns / np.deg2rad(rotation_tolerance)), axis=1)


def gripper_frames(motion: Motion, path: np.ndarray) -> list[int]:
    """The keyframe of each gripper's event: where it is done, or before, where the hand has not left yet.

    Args:
        motion: one episode.
        path: (T, N) of the hand in units of what it may stray.
    """
    frames = []
    for begin, end in gripper_events(motion):
        steps = np.linalg.norm(np.diff(path[begin : end + 1], axis=0), axis=1)
        centre = path[begin + int(np.argmin(steps))] if len(steps) else path[begin]
        there = np.linalg.norm(path[begin : end + 1] - centre, axis=1) <= 0.5
        frames.append(begin + int(np.flatnonzero(there)[-1]))
    return frames


def simplify(path: np.ndarray, begin: int, end: int) -> list[int]:
    """Frames from ``begin`` to ``end`` whose polyline misses no frame of the path (T, N) by more than 1."""
    keep, open_spans = {begin, end}, [(begin, end)]
    while open_spans:
        first, last = open_spans.pop()
        if last - first < 2:
            continue
        misses = _misses(path[first : last + 1])
        worst = int(np.argmax(misses))
        if misses[worst] > 1.0:
            keep.add(first + worst)
            open_spans += [(first, first + worst), (first + worst, last)]
    return sorted(keep)


def _misses(points: np.ndarray) -> np.ndarray:
    """Distance of each point (T, N) from the line between the first and the last one."""
    start, along = points[0], points[-1] - points[0]
    length = float(along @ along)
    shares = np.zeros(len(points)) if length == 0 else ((points - start) @ along / length).clip(0, 1)
    return np.asarray(np.linalg.norm(points - start - shares[:, None] * along, axis=1))


def _fitted(path: np.ndarray, corners: list[int]) -> list[int]:
    """The corners between the first and the last one, moved to where the squares of all misses are least.

    Corners that the polyline then does without are dropped.
    """
    corners = list(corners)
    for _ in range(_FITTING_ROUNDS):
        before = list(corners)
        for place in range(1, len(corners) - 1):
            low, high = corners[place - 1], corners[place + 1]
            costs = [_cost(path, low, middle) + _cost(path, middle, high) for middle in range(low + 1, high)]
            corners[place] = low + 1 + int(np.argmin(costs))
        for place in range(len(corners) - 2, 0, -1):
            if _misses(path[corners[place - 1] : corners[place + 1] + 1]).max() <= 1.0:
                del corners[place]
        if corners == before:
            break
    return corners


def _slowest(speeds: np.ndarray, corner: int, begin: int, end: int, reach: int) -> int:
    """The frame downhill from a corner at which the hand is slowest, not further than ``reach`` from it."""
    low, high = max(begin + 1, corner - reach), min(end - 1, corner + reach)
    here = corner
    while (lower := min(range(max(low, here - 1), min(high, here + 1) + 1), key=lambda at: speeds[at])) != here:
        here = lower
    return here


def _kept(path: np.ndarray, speeds: np.ndarray, corners: list[int]) -> list[int]:
    """The first and the last corner, and those between that are sharp or at which the hand slows down."""
    corners = list(corners)
    while len(corners) > 2:
        slower = []
        for low, at, high in zip(corners, corners[1:], corners[2:], strict=False):
            before, after = path[at] - path[low], path[high] - path[at]
            turned = before @ after <= np.cos(np.deg2rad(_SHARP)) * np.linalg.norm(before) * np.linalg.norm(after)
            there, on = speeds[low : at + 1].max(), speeds[at : high + 1].max()
            slower.append(1.0 if turned else 1 - speeds[at] / max(min(there, on), 1e-12))
        least = int(np.argmin(slower))
        if slower[least] >= _SLOWER:
            break
        del corners[least + 1]
    return corners


def _cost(path: np.ndarray, first: int, last: int) -> float:
    return float(np.square(_misses(path[first : last + 1])).sum())
