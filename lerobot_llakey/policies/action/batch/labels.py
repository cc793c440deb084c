"""What a training sample should be answered with, and its motion together with the scene (augmentation)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor
from torch.nn import functional as F

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.batch.augmentation import RigidMotion
from lerobot_llakey.policies.action.batch.point_cloud import inside
from lerobot_llakey.policies.batch import check_at_least_zero, check_poses


@dataclass
class Labels:
    """The answers of a batch.

    Attributes:
        position: (B, 3) of the next keyframe in metres.
        quaternion: (B, 4) unit, xyzw.
        gripper: (B,) bool, true for open.
        collision: (B,) bool, true where the planner may touch things on the way to this very keyframe.
        heading: (B,) yaw in radians and lift: (B, 3) metres by which the scene has been moved; zero at first.
    """

    position: Tensor
    quaternion: Tensor
    gripper: Tensor
    collision: Tensor
    heading: Tensor
    lift: Tensor


def read_labels(action: Tensor, workspace: Tensor) -> Labels:
    """The labels in actions (B, 9): every one from the row's own action (NVlabs/RVT issue 91 tells of another's).

    Raises:
        LlakeyError: naming the key and batch row if a pose or flag is none, see :func:`check_poses`, or a position lies
            outside the workspace (3, 2) in metres.
    """
    if action.shape[1:] != (schema.ACTION_DIM,):
        raise LlakeyError(
            f"Expected {schema.ACTION} of shape (batch, {schema.ACTION_DIM}) ({', '.join(schema.ACTION_NAMES)}), got "
            f"{tuple(action.shape)}; use a keysteps dataset."
        )
    check_poses(schema.ACTION, action)
    flag = schema.ACTION_NAMES[schema.IGNORE_COLLISION]
    check_at_least_zero(f"{schema.ACTION} ({flag})", action[:, schema.IGNORE_COLLISION, None])
    position, quaternion = action[:, schema.POSITION].float(), action[:, schema.QUATERNION].float()
    outside = ~inside(position, workspace)
    if outside.any():
        row = int(outside.nonzero()[0])
        raise LlakeyError(
            f"Expected keyframes inside the workspace {workspace.tolist()} (metres), got "
            f"{[round(number, 3) for number in position[row].tolist()]} in {schema.ACTION} at batch row {row}; "
            "widen policy.workspace."
        )
    return Labels(
        position=position,
        quaternion=F.normalize(quaternion, dim=-1),
        gripper=action[:, schema.GRIPPER] > 0.5,
        collision=action[:, schema.IGNORE_COLLISION] > 0.5,
        heading=torch.zeros_like(position[:, 0]),
        lift=torch.zeros_like(position),
    )


def moved(
    batch: Mapping[str, Any], labels: Labels, motion: RigidMotion, cameras: Sequence[str], hand: Sequence[int] = ()
) -> tuple[dict[str, Any], Labels]:
    """Cameras, present hand and labels after a rigid motion of the whole scene.

    Args:
        batch: in the data contract.
        labels: its labels.
        motion: of each row.
        cameras: names of those to move.
        hand: where the hand stands in the state, see :func:`hand.hand_columns`; without them it stays.
    """
    batch = dict(batch)
    for key in map(schema.extrinsics_key, cameras):
        batch[key] = motion.move_poses(batch[key].float())
    if hand:
        pose, state = list(hand[: len(schema.POSE_NAMES)]), batch[schema.STATE].float().clone()
        state[:, pose] = motion.move_poses(state[:, pose])
        batch[schema.STATE] = state
    return batch, Labels(
        position=motion.move_points(labels.position),
        quaternion=motion.move_quaternion(labels.quaternion),
        gripper=labels.gripper,
        collision=labels.collision,
        heading=labels.heading + motion.yaw,
        lift=labels.lift + motion.translation,
    )
