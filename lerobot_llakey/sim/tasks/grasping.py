"""Steps that experts share: the two of a grasp, and letting go."""

from __future__ import annotations

import numpy as np

from lerobot_llakey.geometry import Pose
from lerobot_llakey.instructions import instruct
from lerobot_llakey.sim.tasks.base import Waypoint
from lerobot_llakey.sim.world import World

_NEAR = 0.05
_LEAN, _SPIN = 0.35, float(np.deg2rad(60))
"""Radians by which the hand may point elsewhere than its grasp does, and be turned about the way it points."""


def grasping(
    world: World, before: Pose, grasp: Pose, side: str, thing: str, near: float = _NEAR, spin: float = _SPIN
) -> list[Waypoint]:
    """Both steps of a grasp, or the second alone where the hand already waits before it.

    Args:
        world: the present state.
        before: where the grasp begins, in the base frame.
        grasp: the hand around the thing.
        side: of the thing, where the hand waits.
        thing: what is grasped, in words.
        near: metres by which a waiting hand may be beside ``before``.
        spin: radians by which it may be turned about the axis it approaches along.
    """
    steps = [
        Waypoint(before, True, False, instruct("move", side, thing)),
        Waypoint(grasp, False, True, instruct("grasp", thing)),
    ]
    return steps[waits_before(world, before, near, spin) :]


def release(pose: Pose, thing: str) -> Waypoint:
    """Let a thing go at a pose of the hand."""
    return Waypoint(pose, True, True, instruct("release", thing))


def waits_before(world: World, before: Pose, near: float = _NEAR, spin: float = _SPIN) -> bool:
    """Whether the open hand is where a grasp can begin: the grasp itself corrects what is still wrong.

    A hand may be turned far about the axis it approaches along, because it turns on its way to the object. What stands
    far from the cameras often does not show how it is turned before the hand is above it, so that a policy could not do
    better (and an expert that insisted would stand still for ever).
    """
    if world.gripper_closed:
        return False
    distance = float(np.linalg.norm(world.tool.position - before.position))
    return distance < near and points_alike(world.tool, before, spin)


def points_alike(tool: Pose, wanted: Pose, spin: float) -> bool:
    """Whether a hand points about where it should, with no more than ``spin`` radians of turn about that axis."""
    turn = (wanted.rotation.inv() * tool.rotation).as_matrix()
    lean = np.arccos(np.clip(turn[2, 2], -1.0, 1.0))
    spun = abs(np.arctan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1]))
    return bool(lean < _LEAN and spun < spin)
