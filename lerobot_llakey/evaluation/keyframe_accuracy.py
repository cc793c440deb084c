"""How often an action policy finds the next keyframe of recorded samples: the cheap check before any rollout."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sized
from typing import Any, cast

import torch
from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.utils.collate import lerobot_collate_fn
from torch import Tensor
from torch.utils.data import DataLoader, Dataset, Subset

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import rotation_error
from lerobot_llakey.policies.prepared import Preprocessor, prepared

POSITION_LIMITS = (0.01, 0.02)
"""Metres."""
ROTATION_LIMITS = (5.0, 10.0)
"""Degrees."""


def sample_errors(action: Tensor, target: Tensor) -> dict[str, Tensor]:
    """Whether each row (B,) of actions (B, 9) is right, by measure."""
    action, target = action.float().cpu(), target.float().cpu()
    distance = (action[:, schema.POSITION] - target[:, schema.POSITION]).norm(dim=1)
    angle = rotation_error(target[:, schema.QUATERNION], action[:, schema.QUATERNION])
    right = {f"position_within_{round(limit * 100)}cm": distance <= limit for limit in POSITION_LIMITS}
    right |= {f"rotation_within_{round(limit)}deg": angle <= limit for limit in ROTATION_LIMITS}
    for name, column in (("gripper_right", schema.GRIPPER), ("collision_right", schema.IGNORE_COLLISION)):
        right[name] = (action[:, column] > 0.5) == (target[:, column] > 0.5)
    return {name: value.float() for name, value in right.items()} | {"position_error_mm": distance * 1000}


def keyframe_accuracy(
    policy: PreTrainedPolicy,
    dataset: Dataset[Any],
    preprocessor: Preprocessor | None = None,
    postprocessor: Callable[[Tensor], Tensor] | None = None,
    num_samples: int = 0,
    batch_size: int = 16,
    seed: int = 0,
) -> dict[str, dict[str, float]]:
    """Compare a policy's decisions with the next keyframes of a keysteps dataset.

    Args:
        policy: decides on each sample afresh.
        dataset: samples in the data contract.
        preprocessor: the policy's, applied to each batch where given.
        postprocessor: the policy's, applied to each action where given.
        num_samples: drawn at random with the seed; 0 takes all.
        batch_size: samples decided on at once.
        seed: of the draw.

    Returns:
        For each verb (the instruction's first word) and for "all": the share of samples whose position, rotation,
        gripper and collision flag are right, the mean position error in millimetres, and the number of ``samples``.

    Raises:
        LlakeyError: if the dataset is empty or has no instruction column.
    """
    size = len(cast(Sized, dataset))
    if size == 0:
        raise LlakeyError("Expected a keysteps dataset with samples, got an empty one; collect demonstrations first.")
    if num_samples:
        order = torch.randperm(size, generator=torch.Generator().manual_seed(seed))[:num_samples]
        dataset = Subset(dataset, order.tolist())
    sums: defaultdict[str, defaultdict[str, float]] = defaultdict(lambda: defaultdict(float))
    for batch in DataLoader(dataset, batch_size=batch_size, collate_fn=lerobot_collate_fn):
        verbs = _verbs(batch)
        target = batch[schema.ACTION]
        policy.reset()
        action = policy.select_action(prepared(batch, preprocessor))
        errors = sample_errors(postprocessor(action) if postprocessor else action, target)
        for row, verb in enumerate(verbs):
            for group in ("all", verb):
                sums[group]["samples"] += 1
                for name, value in errors.items():
                    sums[group][name] += value[row].item()
    return {
        group: {name: value if name == "samples" else value / total["samples"] for name, value in total.items()}
        for group, total in sorted(sums.items())
    }


def _verbs(batch: Mapping[str, Any]) -> list[str]:
    if schema.INSTRUCTION not in batch:
        raise LlakeyError(
            f"Expected the column {schema.INSTRUCTION}, got a dataset without instruction columns; use keysteps."
        )
    return [text.split(maxsplit=1)[0] if text.strip() else "" for text in batch[schema.INSTRUCTION]]
