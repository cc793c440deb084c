"""The network of our own design: shapes, and what may and may not change its answer."""

from collections.abc import Iterator

import pytest
import torch
from torch import Tensor

from lerobot_llakey.policies.action.networks.small import MultiViewNetwork


@pytest.fixture
def network() -> MultiViewNetwork:
    torch.manual_seed(0)
    return MultiViewNetwork(5, 2, 3, 32, 6, 7, widths=(8, 12, 16), blocks=(1, 1), layers=1, heads=2)


@pytest.fixture
def inputs() -> Iterator[list[Tensor]]:
    padding = torch.tensor([[False, False, True, True]] * 2)
    yield [torch.randn(2, 3, 32, 32, 5), torch.randn(2, 3, 32, 32, 2), torch.randn(2, 6), torch.randn(2, 4, 7), padding]


def test_shapes(network: MultiViewNetwork, inputs: list[Tensor]) -> None:
    output = network(*inputs)
    assert output.heatmap.shape == (2, 3, 32, 32) and output.heatmap.dtype == torch.float32
    assert output.features.shape == (2, 3, 8, 8, 8)
    assert output.summary.shape == (2, 16)


def test_padded_words_change_nothing(network: MultiViewNetwork, inputs: list[Tensor]) -> None:
    before = network(*inputs).heatmap
    inputs[3][:, 2:] = 30.0
    assert torch.allclose(before, network(*inputs).heatmap, atol=1e-5)
    inputs[3][:, 0] += 1.0
    assert not torch.allclose(before, network(*inputs).heatmap, atol=1e-5)


def test_views_see_each_other(network: MultiViewNetwork, inputs: list[Tensor]) -> None:
    before = network(*inputs).heatmap
    inputs[0][:, 2] += 1.0
    assert not torch.allclose(before[:, 0], network(*inputs).heatmap[:, 0], atol=1e-5)


def test_rows_do_not(network: MultiViewNetwork, inputs: list[Tensor]) -> None:
    before = network(*inputs).heatmap
    inputs[0][1] += 1.0
    assert torch.allclose(before[0], network(*inputs).heatmap[0], atol=1e-5)


def test_a_fitting_colour_is_a_short_way_to_heat(network: MultiViewNetwork, inputs: list[Tensor]) -> None:
    before = network(*inputs).heatmap
    network.match_head.bias.data += 2.0
    assert torch.allclose(network(*inputs).heatmap, before + 2.0, atol=1e-5)
