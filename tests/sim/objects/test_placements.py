"""Places on the table."""

import itertools

import numpy as np
import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.objects.placements import draw_until_it_fits, three_placements

FALLBACK = ((0.5, 0.2), (0.5, 0.0), (0.5, -0.2))


def test_positions_keep_their_gaps_and_reach() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        last, first, second = 0.15, 0.2, 0.1
        positions = three_placements(rng, (0.3, 0.6), (-0.3, 0.3), (0.4, 0.65), (last, first, second), FALLBACK)
        assert np.linalg.norm(positions[0] - positions[2]) > last
        assert np.linalg.norm(positions[1] - positions[0]) > first
        assert np.linalg.norm(positions[2] - positions[1]) > second
        away = np.hypot(*positions.T)
        assert (away > 0.4).all() and (away < 0.65).all()


def test_where_nothing_fits_the_given_positions_are_taken() -> None:
    positions = three_placements(np.random.default_rng(0), (0.3, 0.6), (-0.3, 0.3), (0.4, 0.65), (9, 9, 9), FALLBACK)
    assert sorted(map(tuple, positions)) == sorted(FALLBACK)


def test_drawing_ends() -> None:
    assert draw_until_it_fits(iter((None, None, "fits", "late")).__next__, "a thing") == "fits"
    drawn = itertools.count()
    with pytest.raises(LlakeyError, match="Expected room for a thing, got none"):
        draw_until_it_fits(lambda: None if next(drawn) >= 0 else "never", "a thing")
    assert next(drawn) < 10_000
