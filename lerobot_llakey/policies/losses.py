"""The losses of a training batch: weighted by sample, and never a number that is not finite."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.batch import check_at_least_zero


def weighted(losses: Tensor, batch: Mapping[str, Any], key: str = schema.SAMPLE_WEIGHT) -> Tensor:
    """Losses (B,) whose mean is the mean weighted by the batch's sample weights, where it has any.

    Divided by the weights' mean, as LeRobot's own sample weighting does: what counts is how much more one sample
    weighs than another, so that gradients, and the norm they are clipped at, keep their size.

    Args:
        losses: one for each row.
        batch: with weights (B,) or (B, 1) under ``key``, or without.
        key: of the weights.

    Raises:
        LlakeyError: naming the key, and the row where there is one, if a weight is negative or not finite, there is not
            one for each row, or all are zero.
    """
    if key not in batch:
        return losses
    weights = batch[key]
    if weights.numel() != len(losses):
        raise LlakeyError(
            f"Expected {key} with one weight for each of {len(losses)} rows, got shape {tuple(weights.shape)}; give "
            "one a row."
        )
    weights = weights.to(losses).reshape(-1)
    check_at_least_zero(key, weights[:, None])
    mean = weights.mean()
    if mean == 0:
        raise LlakeyError(
            f"Expected {key} with a weight above 0 in each batch, got {len(weights)} zeros; leave out samples that are "
            "not to count."
        )
    return losses * weights / mean


def check_loss(losses: Tensor) -> Tensor:
    """The losses of a training batch, (B,) or one number, if they are finite.

    Raises:
        LlakeyError: if one is not; a step with it would spoil every weight.
    """
    if losses.isfinite().all():
        return losses
    if losses.ndim == 0:
        came = f"{losses.item()}"
    else:
        row = int((~losses.isfinite()).nonzero()[0])
        came = f"{losses[row].item()} in batch row {row}"
    raise LlakeyError(
        f"Expected a finite training loss, got {came}; go on from the last checkpoint with a lower learning rate, or "
        "look for numbers that are not finite in the dataset and the weights."
    )
