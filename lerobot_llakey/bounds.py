"""Numbers that a person sets, held against what makes sense before any work is done."""

from __future__ import annotations

import math

from lerobot_llakey.errors import LlakeyError


def require_number(name: str, value: float, low: float = -math.inf, high: float = math.inf, *, open: str = "") -> None:
    """Refuse a number that is not finite or lies outside its bounds.

    Args:
        name: of the setting, as the person wrote it ("--recovery", "action.crop_size").
        value: the number; whole ones are numbers too, booleans and texts are not.
        low: smallest value that is allowed.
        high: largest value that is allowed.
        open: "low", "high" or "low high": bounds that are not allowed themselves.

    Raises:
        LlakeyError: if the number makes no sense.
    """
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    inside = is_number and math.isfinite(value) and low <= value <= high
    if inside and not ("low" in open and value == low) and not ("high" in open and value == high):
        return
    raise LlakeyError(f"Expected {name} to be a number{_range(low, high, open)}, got {value!r}; correct it.")


def require_count(name: str, value: int, low: int = 0, high: int | None = None) -> None:
    """Refuse what is no whole number or lies outside its bounds.

    Args:
        name: of the setting, as the person wrote it.
        value: the number.
        low: smallest value that is allowed.
        high: largest value that is allowed, None where there is none.

    Raises:
        LlakeyError: if the number makes no sense.
    """
    top = math.inf if high is None else high
    if isinstance(value, int) and not isinstance(value, bool) and low <= value <= top:
        return
    raise LlakeyError(f"Expected {name} to be a whole number{_range(low, top)}, got {value!r}; correct it.")


def _range(low: float, high: float, open: str = "") -> str:
    """The bounds in words, with a space before them."""
    above, below = "low" in open, "high" in open
    if math.isinf(low) and math.isinf(high):
        return " that is finite"
    if math.isinf(high):
        return f" above {low}" if above else f" of {low} or more"
    if math.isinf(low):
        return f" below {high}" if below else f" of {high} or less"
    return f" {'above' if above else 'from'} {low} {'and below' if below else 'to'} {high}"
