"""Numbers that a person sets, held against what makes sense before any work is done."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

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
    is_number = isinstance(value, Real) and not isinstance(value, bool)
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
    if isinstance(value, Integral) and not isinstance(value, bool) and low <= value <= top:
        return
    raise LlakeyError(f"Expected {name} to be a whole number{_range(low, top)}, got {value!r}; correct it.")


def _range(low: float, high: float, open: str = "") -> str:
    """The bounds in words, with a space before them."""
    above, below = "low" in open, "high" in open
    if math.isinf(low) and math.isinf(high):
        return " that is finite"
    lowest, highest = (int(value) if math.isfinite(value) and value == int(value) else value for value in (low, high))
    if math.isinf(high):
        return f" above {lowest}" if above else f" of {lowest} or more"
    if math.isinf(low):
        return f" below {highest}" if below else f" of {highest} or less"
    return f" {'above' if above else 'from'} {lowest} {'and below' if below else 'to'} {highest}"


@dataclass(frozen=True)
class Bounds:
    """What the number, or each number of the list, in a setting may be.

    Attributes:
        low, high: smallest and largest value that is allowed.
        whole: whether it has to be a whole number.
        open: "low", "high" or "low high": bounds that are not allowed themselves.
        optional: whether there may be none.
        length: how many numbers the list has; 0 where it is one number, -1 for any length above 0.
    """

    low: float = 0.0
    high: float = math.inf
    whole: bool = False
    open: str = ""
    optional: bool = False
    length: int = 0

    def require(self, name: str, value: Any) -> None:
        """Refuse a value that makes no sense.

        Raises:
            LlakeyError: naming the setting and what came.
        """
        if value is None and self.optional:
            return
        if not self.length:
            self._require_one(name, value)
            return
        if not isinstance(value, list | tuple) or not value or self.length not in (-1, len(value)):
            count = "one or more numbers" if self.length < 0 else f"{self.length} numbers"
            raise LlakeyError(f"Expected {name} as a list of {count}, got {value!r}; correct it.")
        for place, number in enumerate(value):
            self._require_one(f"{name}[{place}]", number)

    def _require_one(self, name: str, value: Any) -> None:
        if self.whole:
            require_count(name, value, int(self.low), None if math.isinf(self.high) else int(self.high))
        else:
            require_number(name, value, self.low, self.high, open=self.open)


SHARE = Bounds(0, 1)
"""A probability, or a share that may be the whole."""
POSITIVE = Bounds(0, open="low")
COUNT = Bounds(0, whole=True)
AT_LEAST_ONE = Bounds(1, whole=True)


def require_settings(settings: object, bounds: Mapping[str, Bounds]) -> None:
    """Refuse settings with a number that makes no sense.

    Args:
        settings: whose attributes are looked at.
        bounds: by the attribute's name.

    Raises:
        LlakeyError: naming the setting and what came.
    """
    for name, bound in bounds.items():
        bound.require(name, getattr(settings, name))


def require_texts(name: str, texts: Sequence[str], *, some: bool = False) -> None:
    """Refuse a list that holds what is no text, an empty text or the same text twice, or where asked is empty.

    Raises:
        LlakeyError: naming the setting and what came.
    """
    if not isinstance(texts, list | tuple) or any(not isinstance(text, str) or not text.strip() for text in texts):
        raise LlakeyError(f"Expected {name} as a list of texts, got {_short(texts)}; correct it.")
    if some and not texts:
        raise LlakeyError(f"Expected {name} to name at least one, got none; give one or more.")
    if twice := [text for text, count in Counter(texts).items() if count > 1]:
        raise LlakeyError(f"Expected each of {name} once, got {twice[0]!r} more than once; leave it out.")


def require_box(name: str, box: Sequence[Sequence[float]], farthest: float) -> None:
    """Refuse what is not three (low, high) pairs.

    Args:
        name: of the setting.
        box: bounds of x, y and z.
        farthest: what no bound may lie beyond, on either side of zero.

    Raises:
        LlakeyError: naming the setting and what came.
    """
    right = isinstance(box, list | tuple) and len(box) == 3
    right = right and all(isinstance(pair, list | tuple) and len(pair) == 2 for pair in box)
    if not right:
        raise LlakeyError(f"Expected {name} as three (low, high) pairs in metres, got {_short(box)}; correct it.")
    for axis, pair in zip("xyz", box, strict=True):
        for bound in pair:
            require_number(f"{name} ({axis})", bound, -farthest, farthest)
        if not pair[0] < pair[1]:
            raise LlakeyError(
                f"Expected {name} as three (low, high) pairs in metres, got {axis} from {pair[0]} to {pair[1]}; "
                "correct it."
            )


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 200 else f"{text[:200]}..."
