"""Losses are weighted by sample and finite."""

import math

import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.losses import check_loss, weighted


@pytest.mark.parametrize("shape", [(3,), (3, 1)])
def test_the_mean_of_weighted_losses_is_the_weighted_mean(shape: tuple[int, ...]) -> None:
    losses, weights = torch.tensor([1.0, 2.0, 6.0]), torch.tensor([6.0, 0.0, 3.0])
    batch = {schema.SAMPLE_WEIGHT: weights.view(shape)}
    assert weighted(losses, batch).mean().item() == pytest.approx((losses * weights).sum().item() / 9)
    assert torch.allclose(weighted(losses, {schema.SAMPLE_WEIGHT: 10 * weights}), weighted(losses, batch))
    assert weighted(losses, {}) is losses


@pytest.mark.parametrize(
    ("weights", "said"),
    [
        ([1.0, math.nan], "of 0 or more, got .*nan.* in batch row 1"),
        ([math.inf, 1.0], "of 0 or more, got .*inf.* in batch row 0"),
        ([1.0, -1.0], "of 0 or more, got .*-1.0.* in batch row 1"),
        ([0.0, 0.0], "a weight above 0 in each batch, got 2 zeros"),
        ([1.0, 1.0, 1.0], r"one weight for each of 2 rows, got shape \(3,\)"),
    ],
)
def test_weights_that_make_no_sense_are_refused(weights: list[float], said: str) -> None:
    with pytest.raises(LlakeyError, match=rf"Expected observation\.sample_weight (with )?{said}"):
        weighted(torch.ones(2), {schema.SAMPLE_WEIGHT: torch.tensor(weights)})


def test_a_loss_that_is_not_finite_goes_no_further() -> None:
    losses = torch.ones(2)
    assert check_loss(losses) is losses
    with pytest.raises(LlakeyError, match="a finite training loss, got nan in batch row 1"):
        check_loss(torch.tensor([1.0, math.nan]))
    with pytest.raises(LlakeyError, match="a finite training loss, got inf;"):
        check_loss(torch.tensor(math.inf))
