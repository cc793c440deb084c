"""How many answers are right while training."""

from __future__ import annotations

from collections.abc import Sequence

from torch import Tensor


def answer_metrics(
    right: Tensor, counted: Tensor, answers: Sequence[str], previous: Sequence[str] | None = None
) -> dict[str, float]:
    """Shares in 0..1 of tokens and of whole answers predicted right.

    Args:
        right: bool (B, A), tokens predicted right.
        counted: bool (B, A), tokens that belong to an answer.
        answers: the answers (B).
        previous: the instructions last commanded (B), None where they are unknown.

    Returns:
        Tokens predicted right, answers predicted right as a whole, and with ``previous`` the latter among the samples
        whose instruction has just changed: at keyframes and at the start.
    """
    exact = (right | ~counted).all(dim=1).float()
    metrics = {
        "token_accuracy": float((right & counted).sum() / counted.sum()),
        "instruction_accuracy": float(exact.mean()),
    }
    changed = [] if previous is None else [old != new for old, new in zip(previous, answers, strict=True)]
    if any(changed):
        metrics["changed_instruction_accuracy"] = float(exact[changed].mean())
    return metrics
