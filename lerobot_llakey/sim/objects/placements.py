"""Drawing positions on the table."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from lerobot_llakey.errors import LlakeyError

_DRAWS = 200
_ROUNDS = 1000

Range = tuple[float, float]


def draw_until_it_fits[Layout](draw: Callable[[], Layout | None], what: str) -> Layout:
    """The first draw that fits, so that a seed always gives the same one.

    Args:
        draw: draws once; None where it does not fit.
        what: is drawn, in words.

    Raises:
        LlakeyError: if none of 1,000 draws fits.
    """
    for _ in range(_ROUNDS):
        if (layout := draw()) is not None:
            return layout
    raise LlakeyError(f"Expected room for {what}, got none in {_ROUNDS} draws; choose another seed.")


def three_placements(
    rng: np.random.Generator, x: Range, y: Range, reach: Range, gaps: tuple[float, float, float], otherwise: ArrayLike
) -> np.ndarray:
    """Positions of three things that leave room for the hand and are within its reach.

    Args:
        rng: draws them.
        x: metres, base frame.
        y: metres, base frame.
        reach: metres from the base, nearest and farthest.
        gaps: metres at least from the last to the first, the first to the second and the second to the last.
        otherwise: (3, 2) positions that are taken in random order where no draw in 200 fits.

    Returns:
        (3, 2) x and y in metres.
    """
    for _ in range(_DRAWS):
        positions = np.column_stack((rng.uniform(*x, 3), rng.uniform(*y, 3)))
        apart = np.linalg.norm(positions - np.roll(positions, 1, axis=0), axis=1)
        away = np.hypot(*positions.T)
        if (apart > gaps).all() and away.min() > reach[0] and away.max() < reach[1]:
            return positions
    return rng.permutation(np.array(otherwise))
