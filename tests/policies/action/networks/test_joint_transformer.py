"""Attention within views first, then over views and words."""

from collections.abc import Iterator

import pytest
import torch
from torch import Tensor

from lerobot_llakey.policies.action.networks.joint_transformer import PATCH_CHANNELS, GatedBlock, JointTransformer


@pytest.fixture
def inputs() -> Iterator[list[Tensor]]:
    padding = torch.tensor([[False, False, True, True]] * 2)
    yield [torch.randn(2, 3, 2, 2, PATCH_CHANNELS), torch.randn(2, 5), torch.randn(2, 4, 7), padding]


def make(layers: int = 2) -> JointTransformer:
    torch.manual_seed(0)
    return JointTransformer(3, 2, 5, 7, 32, layers, 2, 0.0).eval()


def test_the_first_half_of_the_layers_looks_within_each_view_alone(inputs: list[Tensor]) -> None:
    transformer = make()
    before = transformer(*inputs)
    assert before.shape == (2, 3, 2, 2, 2 * PATCH_CHANNELS)
    seen: list[Tensor] = []
    for layer in transformer.layers:
        layer.register_forward_hook(lambda module, given, result: seen.append(result))
    transformer(*inputs)
    inputs[0][:, 2] += 1.0
    after = transformer(*inputs)
    within = [result.unflatten(0, (2, 3)) for result in (seen[0], seen[2])]
    assert torch.equal(within[0][:, :2], within[1][:, :2]) and not torch.equal(within[0][:, 2], within[1][:, 2])
    assert not torch.allclose(before[:, 0], after[:, 0], atol=1e-6)


def test_words_are_heard_and_padding_is_not(inputs: list[Tensor]) -> None:
    transformer = make()
    before = transformer(*inputs)
    inputs[2][:, 2:] = 30.0
    assert torch.allclose(before, transformer(*inputs), atol=1e-5)
    shorter = transformer(inputs[0], inputs[1], inputs[2][:, :2], inputs[3][:, :2])
    assert torch.allclose(before, shorter, atol=1e-5)
    inputs[2][:, 0] += 1.0
    assert not torch.allclose(before, transformer(*inputs), atol=1e-5)


def test_proprioception_is_felt_and_rows_are_apart(inputs: list[Tensor]) -> None:
    transformer = make()
    before = transformer(*inputs)
    inputs[1][1] += 1.0
    after = transformer(*inputs)
    assert torch.allclose(before[0], after[0], atol=1e-6) and not torch.allclose(before[1], after[1], atol=1e-5)


def test_attention_is_dropped_in_training_alone() -> None:
    torch.manual_seed(0)
    block, tokens = GatedBlock(16, 2, 0.5), torch.randn(1, 6, 16)
    assert not torch.equal(block(tokens), block(tokens))
    block.eval()
    assert torch.equal(block(tokens), block(tokens))
