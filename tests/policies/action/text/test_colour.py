"""Colours are looked up in a table that the words fill."""

import torch

from lerobot_llakey.policies.action.text.colour import LEVELS, ColourGrounding, colour_index


def test_index_is_that_of_the_nearest_lattice_colour() -> None:
    grounding = ColourGrounding(8, 2)
    colours = torch.rand(100, 3, generator=torch.Generator().manual_seed(0))
    apart = colours.double()[:, None] - grounding.lattice[None, :, :3].double()
    nearest = apart.norm(dim=2).argmin(dim=1)  # cdist multiplies matrices: too coarse near the border of two cells
    assert torch.equal(colour_index(colours), nearest)
    assert colour_index(torch.tensor([2.0, -1.0, 0.0])) == (LEVELS - 1) * LEVELS**2


def test_one_step_tells_a_colour_by_its_word() -> None:
    torch.manual_seed(0)
    grounding = ColourGrounding(8, 1)
    words, padding = torch.randn(2, 1, 8), torch.zeros(2, 1, dtype=torch.bool)
    red, blue = colour_index(torch.tensor([[0.9, 0.1, 0.1], [0.1, 0.1, 0.9]]))
    optimiser = torch.optim.Adam(grounding.parameters(), lr=1e-2)
    for _ in range(40):
        table = grounding(words, padding)[..., 0]
        loss = -(table[0, red] - table[0, blue] + table[1, blue] - table[1, red]).clamp(max=4)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    table = grounding(words, padding)[..., 0]
    assert table[0, red] > table[0, blue] and table[1, blue] > table[1, red]


def test_padding_changes_nothing() -> None:
    grounding = ColourGrounding(8, 2)
    words = torch.randn(1, 3, 8)
    padding = torch.tensor([[False, False, True]])
    before = grounding(words, padding)
    words[:, 2] = 50.0
    assert torch.allclose(before, grounding(words, padding), atol=1e-5)
