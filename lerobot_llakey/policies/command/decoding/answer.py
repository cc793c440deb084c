"""Answers of the command policy, their likelihood, and how many of them are correct."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from torch import Tensor, distributed

from lerobot_llakey.grammar import Grammar


@dataclass(frozen=True)
class Answer:
    """One answer of a command policy.

    Attributes:
        text: the instruction.
        likelihood: the probability in 0..1 that the model, at temperature 1, gives this whole answer: the product over
            its tokens, the stop token included, of each token's probability among those that may follow (the next
            tokens of the known answers under the constraint, else the whole vocabulary). Under the constraint the
            likelihoods of all known answers add up to 1, and a token without an alternative counts 1. NaN where the
            model gives no likelihood (the chat backend) or was not asked.
    """

    text: str
    likelihood: float


def count_unparsable(answers: Iterable[Answer], grammar: Grammar) -> int:
    """How many answers are not in the grammar."""
    return sum(not grammar.is_parsable(answer.text) for answer in answers)


def answer_metrics(
    right: Tensor, counted: Tensor, answers: Sequence[str], previous: Sequence[str] | None = None
) -> dict[str, float]:
    """Shares in 0..1 of correct tokens and of correct whole answers.

    Args:
        right: bool (B, A), correctly predicted tokens.
        counted: bool (B, A), tokens that belong to an answer.
        answers: the answers (B).
        previous: the instructions last commanded (B); None if unknown.

    Returns:
        The shares of correct tokens and of correct answers; with ``previous`` also the latter among the samples whose
        instruction has just changed, at keyframes and at the start. The last is left out where there is no such sample,
        and where several processes train: LeRobot averages metrics over processes, and would wait for ever if one of
        them had a metric that another lacks.
    """
    exact = (right | ~counted).all(dim=1).float()
    metrics = {
        "token_accuracy": float((right & counted).sum() / counted.sum()),
        "instruction_accuracy": float(exact.mean()),
    }
    changed = [] if previous is None else [old != new for old, new in zip(previous, answers, strict=True)]
    if any(changed) and not several_processes():
        metrics["changed_instruction_accuracy"] = float(exact[changed].mean())
    return metrics


def several_processes() -> bool:
    """Whether this is one of several processes that train together."""
    return distributed.is_available() and distributed.is_initialized() and distributed.get_world_size() > 1
