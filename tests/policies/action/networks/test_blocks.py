"""The network's building blocks do what their names say."""

import torch

from lerobot_llakey.policies.action.networks.blocks import ConvBlock, Down, Film, TokenBlock, Up


def test_films_start_as_the_identity_and_then_modulate_each_row() -> None:
    film = Film(4, 6)
    features, condition = torch.randn(2, 3, 5, 6), torch.randn(2, 4)
    assert torch.equal(film(features, condition), features)
    torch.nn.init.normal_(film.linear.weight)
    modulated = film(features, condition)
    scale, shift = film.linear(condition).chunk(2, dim=-1)
    assert torch.allclose(modulated[1, 2, 4], features[1, 2, 4] * (1 + scale[1]) + shift[1], atol=1e-6)


def test_views_do_not_mix_in_a_convolution() -> None:
    block = ConvBlock(8, 4)
    features, condition = torch.randn(2, 3, 6, 6, 8), torch.randn(2, 4)
    before = block(features, condition)
    features[:, 1] += 1
    after = block(features, condition)
    assert torch.allclose(before[:, [0, 2]], after[:, [0, 2]], atol=1e-5)
    assert not torch.allclose(before[:, 1], after[:, 1], atol=1e-2)


def test_masked_tokens_are_not_looked_at() -> None:
    block = TokenBlock(8, 2, 4)
    tokens, condition = torch.randn(1, 5, 8), torch.randn(1, 4)
    mask = torch.zeros(1, 1, 1, 5)
    mask[..., 4] = float("-inf")
    before = block(tokens, condition, mask)[:, :4]
    tokens[:, 4] = 100.0
    assert torch.allclose(before, block(tokens, condition, mask)[:, :4], atol=1e-5)


def test_up_puts_patches_where_down_took_them() -> None:
    down, up = Down(2, 8), Up(8, 2)
    torch.nn.init.eye_(down.linear.weight)
    torch.nn.init.eye_(up.linear.weight)
    torch.nn.init.zeros_(down.linear.bias)
    torch.nn.init.zeros_(up.linear.bias)
    features = torch.randn(2, 3, 4, 6, 2)
    assert down(features).shape == (2, 3, 2, 3, 8)
    assert torch.allclose(up(down(features)), features)
