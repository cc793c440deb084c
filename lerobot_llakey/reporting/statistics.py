"""The statistics of the protocol: trimmed mean and spread over repeats, and intervals of shares."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import NormalDist, fmean, stdev

from lerobot_llakey.errors import LlakeyError

_FEWEST_TO_DROP_FROM = 3


def kept(values: Sequence[float]) -> list[float]:
    """The repeats that count: without the best and the worst (paper, section IV-B), where there are three or more."""
    return sorted(values)[1:-1] if len(values) >= _FEWEST_TO_DROP_FROM else list(values)


def trimmed_mean(values: Sequence[float]) -> float:
    """Mean of the repeats that count.

    Raises:
        LlakeyError: if there are none.
    """
    if not values:
        raise LlakeyError("Expected the figures of at least one repeat, got none.")
    return fmean(kept(values))


def spread(values: Sequence[float]) -> float:
    """Standard deviation (of a sample) over the repeats that count; 0 for one alone."""
    counted = kept(values)
    return stdev(counted) if len(counted) > 1 else 0.0


def wilson(successes: int, count: int, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of a share, after Wilson (1927): sensible for few episodes and for shares of 0 and 1.

    Returns:
        Lower and upper bound in 0..1; the whole range where ``count`` is 0.
    """
    if count == 0:
        return 0.0, 1.0
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    share, widening = successes / count, z * z / count
    centre = (share + widening / 2) / (1 + widening)
    half = z * ((share * (1 - share) + widening / 4) / count) ** 0.5 / (1 + widening)
    return max(0.0, centre - half), min(1.0, centre + half)
