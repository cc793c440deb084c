"""How many answers are right while training."""

from __future__ import annotations

from collections.abc import Sequence

from torch import Tensor, distributed


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
        whose instruction has just changed: at keyframes and at the start. The last is left out where there is no such
        sample, and where several processes train: LeRobot averages metrics over processes, and waits for ever if one
        of them has a metric that another lacks.
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
