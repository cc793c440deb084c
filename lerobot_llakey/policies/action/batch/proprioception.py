"""Proprioception: the present hand, and the timestep of the episode."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor
from torch.nn import functional as F

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.batch.augmentation import blurred
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.action.heads.targets import quaternion_to_angles
from lerobot_llakey.policies.batch import check_at_least_zero, read_hands, read_numbers

EPISODE_STEPS = 25
"""Longest episode, in keyframe actions, that the timestep is scaled by (PerAct, RVT)."""


@dataclass
class Proprioception:
    """The present hand, as far as ``config.proprioception`` includes it.

    Attributes:
        vector: (B, P) the network's input: the gripper's opening; with the pose, sine and cosine of the hand's angles;
            with ``use_timestep``, the timestep.
        position: (B, 3) metres, NaN without the pose.
        angles: (B, 3) of the hand in radians, see :mod:`heads.targets`; zero without the pose.
    """

    vector: Tensor
    position: Tensor
    angles: Tensor


def proprioception_width(config: LlakeyActionConfig) -> int:
    """P of :attr:`Proprioception.vector`."""
    return (7 if config.proprioception == "pose" else 1) + config.use_timestep


def read_proprioception(
    batch: Mapping[str, Any], config: LlakeyActionConfig, rows: int, rotation_blur: float = 0.0
) -> Proprioception:
    """Read from a batch the state and the step (B, 1) that the settings ask for.

    Args:
        batch: in the data contract, with the cameras of ``config``.
        config: names the parts to read.
        rows: B.
        rotation_blur: degrees, see :func:`augmentation.blurred`; 0 keeps the orientation exact.

    Raises:
        LlakeyError: if the step or the state is asked for and missing, or makes no sense in a row.
    """
    device = batch[schema.image_key(config.cameras[0])].device
    opening, angles = torch.zeros(rows, 1, device=device), torch.zeros(rows, 3, device=device)
    position = torch.full((rows, 3), torch.nan, device=device)
    directions = torch.zeros(rows, 6, device=device)
    if config.proprioception != "none":
        if schema.STATE not in batch:
            raise LlakeyError(
                f"Expected {schema.STATE} in the batch, got none; add it or train with policy.proprioception=none."
            )
        hand = read_hands(batch, config.hand_columns, rows).float()
        opening = hand[:, schema.GRIPPER, None]
        if config.proprioception == "pose":
            position = hand[:, schema.POSITION]
            orientation = F.normalize(hand[:, schema.QUATERNION], dim=-1)
            angles = quaternion_to_angles(blurred(orientation, rotation_blur) if rotation_blur > 0 else orientation)
            directions = torch.cat((angles.sin(), angles.cos()), dim=1)
    parts = [opening, directions] if config.proprioception == "pose" else [opening]
    if config.use_timestep:
        parts.append(_timestep(batch, rows))
    return Proprioception(torch.cat(parts, dim=1), position, angles)


def _timestep(batch: Mapping[str, Any], rows: int) -> Tensor:
    """1 at an episode's first action, -1 at its last (RVT)."""
    if schema.STEP not in batch:
        raise LlakeyError(
            f"Expected {schema.STEP} (keyframe actions taken so far) in the batch as policy.use_timestep is on, got "
            "none; add the column or train a policy without the timestep."
        )
    step = batch[schema.STEP]
    if step.ndim == 1:  # LeRobot's loader leaves out the axis of a single number
        step = step[:, None]
    step = read_numbers({schema.STEP: step}, schema.STEP, (1,), rows).float()
    check_at_least_zero(schema.STEP, step)
    return 1 - 2 * step / (EPISODE_STEPS - 1)
