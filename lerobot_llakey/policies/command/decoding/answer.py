"""What a command policy says, and how sure it is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from lerobot_llakey.grammar import Grammar


@dataclass(frozen=True)
class Answer:
    """One answer of a command policy.

    Attributes:
        text: the instruction.
        likelihood: the probability in 0..1 that the model, at temperature 1, gives this whole answer: the product over
            its tokens, the stop token included, of each token's probability among those that may follow (with the known
            answers as the constraint, their next tokens; else the whole vocabulary). Under the constraint the
            likelihoods of all known answers add up to 1, and a token that is the only one to follow counts 1. It is the
            same for a drawn answer, whatever the temperature it was drawn at. NaN where the model does not tell (the
            chat backend) or was not asked.
    """

    text: str
    likelihood: float


def count_unparsable(answers: Iterable[Answer], grammar: Grammar) -> int:
    """How many answers are not in the grammar."""
    return sum(not grammar.is_parsable(answer.text) for answer in answers)
