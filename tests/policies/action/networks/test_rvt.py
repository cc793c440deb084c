"""RVT's network, small: shapes, what reaches what, and the skip from the early pixels."""

import torch

from lerobot_llakey.policies.action.networks.rvt import RvtNetwork


def make() -> RvtNetwork:
    torch.manual_seed(0)
    return RvtNetwork(
        channels=10, views=2, size=10, patch=5, condition=3, text_width=7, width=16, layers=2, heads=2
    ).eval()


def inputs() -> list[torch.Tensor | None]:
    torch.manual_seed(1)
    padding = torch.zeros(1, 4, dtype=torch.bool)
    return [torch.randn(1, 2, 10, 10, 10), None, torch.randn(1, 3), torch.randn(1, 4, 7), padding]


def test_shapes() -> None:
    output = make()(*inputs())
    assert output.heatmap.shape == (1, 2, 10, 10) and output.heatmap.dtype == torch.float32
    assert output.features.shape == (1, 2, 10, 10, 64)
    assert output.summary.shape == (1, 2 * 128)


def test_one_pixel_is_seen_at_full_resolution() -> None:
    # Without the transformer only the skip is left: a pixel then changes the heatmap of the 5x5 around it alone.
    network, given = make(), inputs()
    torch.nn.init.zeros_(network.before_up.weight)
    torch.nn.init.zeros_(network.before_up.bias)
    before = network(*given).heatmap
    given[0][0, 1, 6, 3] += 1.0
    changed = (network(*given).heatmap - before).abs() > 1e-7
    assert not changed[0, 0].any()
    rows, columns = changed[0, 1].nonzero().unbind(1)
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (4, 8, 1, 5)


def test_the_summary_is_the_greatest_of_each_views_tokens() -> None:
    network, given = make(), inputs()
    tokens = []
    network.transformer.register_forward_hook(lambda module, arguments, result: tokens.append(result))
    summary = network(*given).summary
    assert torch.equal(summary.view(2, 128), tokens[0][0].flatten(1, 2).max(dim=1).values)
