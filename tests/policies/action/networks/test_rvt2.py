"""RVT-2's network, small: shapes, and features that are the transformer's tokens."""

import torch

from lerobot_llakey.policies.action.networks.rvt2 import Rvt2Network


def make() -> Rvt2Network:
    torch.manual_seed(0)
    return Rvt2Network(
        channels=10, views=2, size=12, patch=4, condition=3, text_width=7, width=16, layers=2, heads=2
    ).eval()


def inputs() -> list[torch.Tensor | None]:
    torch.manual_seed(1)
    padding = torch.zeros(2, 4, dtype=torch.bool)
    return [torch.randn(2, 2, 12, 12, 10), None, torch.randn(2, 3), torch.randn(2, 4, 7), padding]


def test_shapes() -> None:
    network, given = make(), inputs()
    tokens = []
    network.transformer.register_forward_hook(lambda module, arguments, result: tokens.append(result))
    output = network(*given)
    assert output.heatmap.shape == (2, 2, 12, 12) and output.heatmap.dtype == torch.float32
    assert output.features.shape == (2, 2, 3, 3, 128) and torch.equal(output.features, tokens[0])
    assert torch.equal(output.summary.view(2, 2, 128), tokens[0].amax(dim=(2, 3)))


def test_patches_are_cut_as_the_views_lie() -> None:
    network, given = make(), inputs()
    patches = []
    network.patches.register_forward_hook(lambda module, arguments, result: patches.append(result))
    network(*given)
    given[0][1, 0, 5, 10] += 1.0
    network(*given)
    changed = (patches[0] != patches[1]).any(dim=-1)
    assert changed.nonzero().tolist() == [[1, 0, 1, 2]]


def test_the_words_reach_the_heat() -> None:
    network, given = make(), inputs()
    before = network(*given).heatmap
    given[3][1] += 1.0
    after = network(*given).heatmap
    assert torch.allclose(before[0], after[0], atol=1e-6) and not torch.allclose(before[1], after[1], atol=1e-6)
