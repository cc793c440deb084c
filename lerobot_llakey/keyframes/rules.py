"""A choice of rules for keyframes, their union, and the merging of what two rules found almost alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lerobot_llakey.bounds import require_number
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.keyframes.gripper import gripper_events
from lerobot_llakey.keyframes.motion import Motion
from lerobot_llakey.keyframes.rest import discover_keyframes, pose_numbers
from lerobot_llakey.keyframes.speed import speed_keyframes
from lerobot_llakey.keyframes.waypoints import hand_path, waypoint_keyframes

RULES = ("rest", "waypoints", "speed")
"""What ``--keyframes`` may name, joined by a plus sign; of two almost alike, the earlier named rule's is kept."""


@dataclass(frozen=True)
class RuleSettings:
    """What counts as a keyframe.

    Attributes:
        min_rest: seconds that the robot rests at a keyframe at least.
        joint: radians that a resting joint may stray.
        position: metres that a resting hand may stray, where no joints are named.
        rotation: radians that it may turn.
        gripper: share of its travel that a resting gripper may stray.
        path: metres by which the polyline between waypoints may miss the hand's path.
        turn: degrees by which it may miss its rotation.
        prominence: of a minimum of the hand's speed, as a share of the episode's high speed.
        merge: seconds within which two keyframes are one.
    """

    min_rest: float = 0.2
    joint: float = 0.01
    position: float = 0.004
    rotation: float = 0.02
    gripper: float = 0.03
    path: float = 0.015
    turn: float = 7.5
    prominence: float = 0.3
    merge: float = 0.3


def parse_rules(text: str) -> tuple[str, ...]:
    """The rules that a person names, "rest" or "rest+waypoints".

    Raises:
        LlakeyError: if one is unknown or named twice.
    """
    names = tuple(part.strip() for part in text.split("+"))
    if not set(names) <= set(RULES) or len(set(names)) != len(names):
        raise LlakeyError(
            f"Expected --keyframes as {', '.join(RULES)} or several joined by +, got {text!r}; give one such as "
            "rest+waypoints."
        )
    return names


def find_by_rules(motion: Motion, rules: tuple[str, ...], settings: RuleSettings | None = None) -> list[int]:
    """The keyframes of one episode that any of the rules finds.

    Args:
        motion: the episode.
        rules: as :func:`parse_rules` gives them.
        settings: what counts as a keyframe.

    Returns:
        Increasing frame indices; the last one is T - 1.

    Raises:
        LlakeyError: if a setting makes no sense.
    """
    settings = settings or RuleSettings()
    require_number("merge_within", settings.merge, 0, 60)
    found = [(rule, frame) for rule in rules for frame in _of_rule(motion, rule, settings)]
    return _merged(motion, found, rules, settings)


def _of_rule(motion: Motion, rule: str, settings: RuleSettings) -> list[int]:
    if rule == "waypoints":
        return waypoint_keyframes(motion, position_tolerance=settings.path, rotation_tolerance=settings.turn)
    if rule == "speed":
        return speed_keyframes(motion, prominence=settings.prominence)
    arm = motion.joints
    return discover_keyframes(
        pose_numbers(motion.poses, settings.position, settings.rotation) if arm is None else arm,
        motion.openings,
        motion.fps,
        min_rest=settings.min_rest,
        arm_tolerance=1.0 if arm is None else settings.joint,
        gripper_tolerance=settings.gripper,
    )


def _merged(motion: Motion, found: list[tuple[str, int]], rules: tuple[str, ...], settings: RuleSettings) -> list[int]:
    """One of any keyframes that lie within a moment, or between which neither hand nor gripper went anywhere.

    ``rest`` alone is left as it is: its keyframes have a motion between them.
    """
    if rules == ("rest",):
        return sorted({frame for _, frame in found})
    last, within = len(motion) - 1, settings.merge * motion.fps
    path, ends = hand_path(motion, settings.path, settings.turn), np.array([end for _, end in gripper_events(motion)])

    def alike(one: int, other: int) -> bool:
        low, high = min(one, other), max(one, other)
        if high - low <= within:
            return True
        acted = bool(((ends > low + within) & (ends <= high)).any())
        return not acted and bool(np.linalg.norm(path[low : high + 1] - path[high], axis=1).max() <= 1.0)

    def rank(one: tuple[str, int]) -> tuple[bool, bool, int, int]:
        rule, frame = one
        return frame != last, not (np.abs(ends - frame) <= within).any(), rules.index(rule), frame

    kept: list[int] = []
    for _, frame in sorted(found, key=rank):  # the last one, the gripper's, then in the order of the rules
        if not any(alike(frame, other) for other in kept):
            kept.append(frame)
    return sorted(kept)
