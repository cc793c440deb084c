"""Which of the action policy's weights are trained how."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from torch import nn

MUON_LEAST = 32
"""Rows and columns from which on a weight of the views' networks counts as a hidden matrix."""


def parameter_groups(named: Iterable[tuple[str, nn.Parameter]], muon: bool) -> list[dict[str, Any]]:
    """Groups for the optimiser: weights, vectors, which do not decay, and where wanted hidden matrices for Muon.

    Args:
        named: parameters with their names in the policy; those without a gradient are left out.
        muon: whether the hidden matrices and kernels of the views' networks form a group of their own.
    """
    hidden: list[nn.Parameter] = []
    weights: list[nn.Parameter] = []
    vectors: list[nn.Parameter] = []
    for name, value in named:
        if value.requires_grad:
            is_hidden = muon and ".network." in name and min(value.shape[:2]) >= MUON_LEAST
            (vectors if value.ndim < 2 else hidden if is_hidden else weights).append(value)
    groups: list[dict[str, Any]] = [{"params": weights}, {"params": vectors, "weight_decay": 0.0}]
    return [*groups, {"params": hidden, "muon": True}] if hidden else groups
