"""Convex upsampling: means of neighbours, in the right places."""

import torch

from lerobot_llakey.policies.action.networks.upsampling import ConvexUpsampling


def make(factor: int = 3) -> ConvexUpsampling:
    torch.manual_seed(0)
    return ConvexUpsampling(4, factor)


def test_each_fine_pixel_lies_between_its_coarse_neighbours() -> None:
    upsampling, features = make(), torch.randn(2, 4, 5, 6)
    fine = upsampling(features)
    assert fine.shape == (2, 15, 18)
    coarse = torch.nn.functional.pad(upsampling.values(features).squeeze(1), (1, 1, 1, 1))
    for row, column in ((0, 0), (7, 3), (14, 17)):
        around = coarse[:, row // 3 : row // 3 + 3, column // 3 : column // 3 + 3].flatten(1)
        assert ((fine[:, row, column] > around.amin(1) - 1e-6) & (fine[:, row, column] < around.amax(1) + 1e-6)).all()


def test_weights_are_put_where_they_belong() -> None:
    upsampling, features = make(factor=2), torch.randn(1, 4, 3, 3)
    last = upsampling.weights[-1]
    torch.nn.init.zeros_(last.weight)
    # The lower left pixel of each block (row 1, column 0) takes the coarse value on its right, all others their own.
    logits = torch.full((9, 2, 2), -1000.0)
    logits[4] = 1000.0
    logits[4, 1, 0], logits[5, 1, 0] = -1000.0, 1000.0
    last.bias.data = logits.flatten()
    coarse, fine = upsampling.values(features)[0, 0], upsampling(features)[0]
    assert torch.allclose(fine[::2, ::2], coarse) and torch.allclose(fine[1::2, 1::2], coarse)
    assert torch.allclose(fine[1::2, :4:2], coarse[:, 1:])


def test_it_is_learned() -> None:
    upsampling = make()
    upsampling(torch.randn(1, 4, 4, 4)).square().sum().backward()
    assert all(parameter.grad.any() for parameter in upsampling.parameters())
