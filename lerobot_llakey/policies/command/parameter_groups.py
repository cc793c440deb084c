"""Sorts parameters by how an optimiser should treat them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from torch import Tensor


def parameter_groups(named: Iterable[tuple[str, Tensor]]) -> list[dict[str, Any]]:
    """Trained parameters in groups: hidden matrices (for Muon), other weights, and what does not decay.

    Args:
        named: names and parameters; those that need no gradient are left out.
    """
    hidden: list[Tensor] = []
    weights: list[Tensor] = []
    rest: list[Tensor] = []
    for name, value in named:
        if not value.requires_grad:
            continue
        if value.ndim < 2 or "embed" in name:
            rest.append(value)
        elif value.ndim == 2 and ".layers." in name:
            hidden.append(value)
        else:
            weights.append(value)
    return [{"params": hidden, "muon": True}, {"params": weights}, {"params": rest, "weight_decay": 0.0}]
