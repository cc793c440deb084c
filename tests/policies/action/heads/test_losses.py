"""Loss parts against their definitions."""

import math

import pytest
import torch

from lerobot_llakey import geometry
from lerobot_llakey.policies.action.heads.losses import (
    flag_loss,
    heatmap_loss,
    share_right,
    share_turned_less,
    share_within,
)
from lerobot_llakey.policies.action.networks.view_network import ViewOutput

VIEWS = ("top", "front", "side")


def output(heatmap: torch.Tensor) -> ViewOutput:
    return ViewOutput(heatmap, torch.zeros(0), torch.zeros(0))


def test_the_heat_loss_is_the_cross_entropy_over_pixels() -> None:
    even = heatmap_loss(output(torch.zeros(2, 3, 8, 8)), torch.rand(2, 3), VIEWS, 1.0)
    assert torch.allclose(even, torch.full((2,), math.log(64)))
    heatmap = torch.zeros(1, 3, 8, 8)
    heatmap[0, 0, 2, 5] = heatmap[0, 1, 7, 5] = heatmap[0, 2, 7, 2] = 40.0
    point = torch.tensor([[2.5, 5.5, 7.5]]) / 8
    assert heatmap_loss(output(heatmap), point, VIEWS, 0.1).item() == pytest.approx(0.0, abs=1e-5)
    assert heatmap_loss(output(heatmap), point.flip(1), VIEWS, 0.1).item() > 20


def test_hits_are_counted_by_view() -> None:
    heatmap = torch.zeros(1, 3, 8, 8)
    heatmap[0, 0, 2, 5] = heatmap[0, 1, 7, 5] = heatmap[0, 2, 7, 5] = 1.0
    point = torch.tensor([[2.5, 5.5, 7.5]]) / 8
    assert share_within(output(heatmap), point, VIEWS, 0.01) == pytest.approx(2 / 3)
    assert share_within(output(heatmap), point, VIEWS, 0.5) == 1.0


def test_flags() -> None:
    logits, flag = torch.tensor([[0.0, 2.0], [0.0, 2.0]]), torch.tensor([True, False])
    expected = torch.tensor([math.log1p(math.exp(-2)), math.log1p(math.exp(2))])
    assert torch.allclose(flag_loss(logits, flag), expected)
    assert share_right(logits, flag) == 0.5


def test_turns_are_compared_whatever_the_quaternions_sign() -> None:
    first = torch.from_numpy(geometry.top_down(0.0)).float().expand(3, 4)
    second = torch.stack([torch.from_numpy(geometry.top_down(math.radians(angle))).float() for angle in (0, 4, 6)])
    assert share_turned_less(first, -second, 5.0) == pytest.approx(2 / 3)
