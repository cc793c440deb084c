"""What is wrong with a dataset, said in one sentence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Place:
    """The first row in which something is wrong.

    Attributes:
        words: how a finding names it, with the number of further rows.
        episode: its episode, None where no column tells.
        frame: its frame within the episode.
    """

    words: str
    episode: int | None = None
    frame: int | None = None

    def __str__(self) -> str:
        return self.words


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong, or that is likely to be.

    Attributes:
        column: where it is.
        expected: what should be there.
        got: what is there.
        advice: what to do.
        place: the first row in which it is seen.
        certain: whether training on it is refused; a warning otherwise.
    """

    column: str
    expected: str
    got: str
    advice: str
    place: Place | None = None
    certain: bool = True

    def sentence(self, dataset: str) -> str:
        """The finding as an error or a warning says it."""
        place = f" at {self.place}" if self.place else ""
        return f"Expected {self.expected} in {self.column} of {dataset}, got {self.got}{place}; {self.advice}."

    @property
    def kind(self) -> tuple[str, str]:
        """What two findings of the same fault share."""
        return self.column, self.expected


def told(values: np.ndarray) -> str:
    """Numbers, or rows of numbers, as a finding shows them."""
    if values.ndim == 0:
        return f"{values:.4g}"
    return "[" + ", ".join(told(np.asarray(value)) for value in values) + "]"
