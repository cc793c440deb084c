"""Choosing a token: the most probable one, or one drawn by its probability."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from lerobot_llakey.errors import LlakeyError


@dataclass(frozen=True)
class Choice:
    """How tokens are chosen.

    Attributes:
        sample: draw each token by its probability, from PyTorch's generator; the most probable one otherwise.
        temperature: divides the scores before the draw; below 1 the draw is nearer to the most probable one.

    Raises:
        LlakeyError: if the temperature is not above 0.
    """

    sample: bool = False
    temperature: float = 1.0

    def __post_init__(self) -> None:
        if not self.temperature > 0:
            raise LlakeyError(
                f"Expected a temperature above 0, got {self.temperature}; sample=False takes the likeliest."
            )

    def pick(self, scores: Tensor) -> int:
        """Index of the token chosen by its score (K,); the first of several equal ones."""
        if not self.sample:
            return int(scores.argmax())
        return int(torch.multinomial(torch.softmax(scores / self.temperature, dim=0), 1))


GREEDY = Choice()
"""Always the most probable token."""
