"""Durations as people say them."""

from __future__ import annotations


def clock(seconds: float) -> str:
    """Seconds in words: seconds up to a minute and a half, minutes up to an hour and a half, then hours."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 90 else f"{minutes / 60:.1f} h"
