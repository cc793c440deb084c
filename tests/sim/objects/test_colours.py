"""Twenty colours that can be told apart."""

from itertools import combinations

import numpy as np

from lerobot_llakey.instructions import instruct, parse
from lerobot_llakey.sim.objects.colours import COLOUR_NAMES, COLOURS


def test_twenty_colours_within_range_and_apart() -> None:
    assert len(COLOURS) == 20
    assert all(0 <= channel <= 1 for colour in COLOURS.values() for channel in colour)
    assert min(np.abs(np.subtract(a, b)).max() for a, b in combinations(COLOURS.values(), 2)) >= 0.25


def test_every_name_fits_the_grammar() -> None:
    for name in COLOUR_NAMES:
        assert parse(instruct("align", f"the {name} jar")).arguments == (f"the {name} jar",)
