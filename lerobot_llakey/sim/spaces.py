"""What goes into the environment and comes out of it: Gymnasium's spaces, and the check of an action."""

from __future__ import annotations

import logging
import math
from typing import Any

import numpy as np
from gymnasium import spaces

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.arm.planning import PlanningError

_LOG = logging.getLogger(__name__)

_BOUND = 2.0
"""Bound of an action's numbers; a position beyond it is out of reach."""
_BESIDE = 0.5
"""By how much a flag may lie outside 0..1: a policy that regresses it is never quite there, other units are far off."""
_LENGTHS = (0.1, 10.0)
"""Lengths of a quaternion that a policy may have meant as 1."""


def checked_action(action: Any) -> np.ndarray:
    """An action as (9,) float64.

    Raises:
        LlakeyError: if it is no action: another shape or kind, or not finite.
    """
    wanted = f"an action of {schema.ACTION_DIM} finite numbers ({', '.join(schema.ACTION_NAMES)})"
    try:
        numbers = np.asarray(action)
    except (ValueError, TypeError, RuntimeError) as error:  # lists of unequal lengths, tensors on a GPU
        raise LlakeyError(f"Expected {wanted}, got what is no array ({error}); check the policy's output.") from error
    if numbers.shape != (schema.ACTION_DIM,) or numbers.dtype.kind not in "fiu":
        came = f"{numbers.dtype} of shape {numbers.shape}"
        raise LlakeyError(f"Expected {wanted}, got {came}; check the policy's output.")
    numbers = numbers.astype(np.float64)
    if not np.isfinite(numbers).all():
        raise LlakeyError(f"Expected {wanted}, got {numbers}; check the policy's output.")
    return numbers


def require_units(action: np.ndarray) -> None:
    """Refuse to carry out an action (9,) that means no pose and no flags, as a pose out of reach is refused.

    Policies that regress actions give anything before they are trained; one in other units is told by the log.

    Raises:
        PlanningError: if the quaternion is far from length 1, or a flag far from 0 and 1.
    """
    length = math.hypot(*action[schema.QUATERNION])
    wrong = [] if _LENGTHS[0] <= length <= _LENGTHS[1] else [f"a quaternion of length 1, got one of {length:g}"]
    for column in (schema.GRIPPER, schema.IGNORE_COLLISION):
        if not -_BESIDE <= action[column] <= 1 + _BESIDE:
            wrong.append(f"{schema.ACTION_NAMES[column]} to be 0 or 1, or between, got {action[column]:g}")
    if wrong:
        _LOG.warning("Expected %s: the arm stays; check the units of the policy's output.", ", and ".join(wrong))
        raise PlanningError("unreachable")


def action_space() -> spaces.Box:
    """Of keyframe actions (9,)."""
    return spaces.Box(-_BOUND, _BOUND, (schema.ACTION_DIM,), np.float32)


def observation_space(size: int, oracle_instructions: bool) -> spaces.Dict:
    """Of observations.

    Args:
        size: height and width in pixels of the cameras.
        oracle_instructions: whether they hold the expert's instruction.
    """
    space: dict[str, spaces.Space] = {
        "pixels": spaces.Dict({camera: spaces.Box(0, 255, (size, size, 3), np.uint8) for camera in schema.CAMERAS}),
        "agent_pos": _unbounded(len(schema.SIM_STATE_NAMES)),
        "velocity": _unbounded(len(schema.SIM_VELOCITY_NAMES)),
        "step": _unbounded(1),
    }
    for camera in schema.CAMERAS:
        space[f"images.{camera}_depth"] = spaces.Box(0.0, np.inf, (1, size, size), np.float32)
        space[f"camera_intrinsics.{camera}"] = _unbounded(len(schema.INTRINSICS_NAMES))
        space[f"camera_extrinsics.{camera}"] = _unbounded(len(schema.POSE_NAMES))
    if oracle_instructions:
        space["oracle_instruction"] = _unbounded(schema.TEXT_LENGTH)
    return spaces.Dict(space)


def _unbounded(*shape: int) -> spaces.Box:
    return spaces.Box(-np.inf, np.inf, shape, np.float32)
