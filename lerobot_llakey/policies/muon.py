"""The Muon optimiser for hidden matrices, with AdamW for all else: ``--optimizer.type=muon`` in LeRobot.

Muon makes the momentum of a matrix nearly orthogonal before it is applied, so that no direction of the update is lost
beside the strongest. Small transformers then learn from far fewer samples, which is what a CPU has. Source: Jordan et
al., "Muon: an optimizer for hidden layers in neural networks" (2024); the scale that lets it share AdamW's learning
rate: Liu et al., "Muon is scalable for LLM training" (2025).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, overload

import torch
from lerobot.optim import OptimizerConfig
from torch import Tensor

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.precision import resolve

_COEFFICIENTS = (3.4445, -4.7750, 2.0315)
"""Of the Newton-Schulz polynomial: it lifts every singular value towards 1 in five rounds, some to 0.7 or 1.2."""
_ROUNDS = 5
_MUCH_WIDER = 1.8
"""Columns a row from which on :func:`_by_gram` is the faster way."""


def orthogonalised(matrix: Tensor) -> Tensor:
    """A matrix (M, N) with the same singular vectors whose singular values are all near 1.

    In bfloat16, which is exact enough, where the device computes fast in it, in float32 elsewhere.
    """
    wide = matrix.to(resolve("auto", matrix.device))
    if matrix.shape[0] > matrix.shape[1]:
        wide = wide.T
    wide = wide / (wide.norm() + 1e-7)
    if wide.dtype == torch.float32 and wide.shape[1] > _MUCH_WIDER * wide.shape[0]:
        wide = _by_gram(wide)
    else:
        a, b, c = _COEFFICIENTS
        for _ in range(_ROUNDS):
            gram = wide @ wide.T
            # c * gram @ gram + b * gram, then that times wide + a * wide.
            wide = torch.addmm(wide, torch.addmm(gram, gram, gram, beta=b, alpha=c), wide, beta=a)
    return wide.T if matrix.shape[0] > matrix.shape[1] else wide


def _by_gram(wide: Tensor) -> Tensor:
    """The same rounds for a matrix (M, N) with M much less than N, mostly in products of (M, M).

    Each round multiplies the matrix from the left with a polynomial of its Gram matrix G, which commutes with G: so the
    next Gram matrix is known without the matrix. It takes float32, since G's own rounding grows by 12 in each round.
    """
    a, b, c = _COEFFICIENTS
    gram = wide @ wide.T
    total: Tensor | None = None
    for left in reversed(range(_ROUNDS)):
        factor = torch.addmm(gram, gram, gram, beta=b, alpha=c)
        factor.diagonal().add_(a)
        total = factor if total is None else factor @ total
        if left:
            gram = factor @ gram @ factor
    assert total is not None
    return total @ wide


class Muon(torch.optim.AdamW):
    """Muon for the parameter groups marked ``{"muon": True}``, AdamW for the others.

    Args:
        params: parameter groups; those marked hold matrices (M, N) and convolutions' kernels (M, N, ...) only, which
            are taken as matrices (M, N * ...).
        momentum: of the matrices' gradients (Nesterov's form).
        **kwargs: as for ``torch.optim.AdamW``; the learning rate and weight decay are meant for both kinds.

    Raises:
        LlakeyError: if a marked group holds a vector.
    """

    def __init__(self, params: Any, momentum: float = 0.95, **kwargs: Any) -> None:
        super().__init__(params, **kwargs)
        self.defaults |= {"muon": False, "momentum": momentum}
        for group in self.param_groups:
            group.setdefault("muon", False)
            group.setdefault("momentum", momentum)
            shapes = {tuple(value.shape) for value in group["params"] if group["muon"] and value.ndim < 2}
            if shapes:
                raise LlakeyError(f"Expected matrices in a group marked for Muon, got {shapes}; leave these to AdamW.")

    @overload
    def step(self, closure: None = None) -> None: ...

    @overload
    def step(self, closure: Callable[[], float]) -> float: ...

    @torch.no_grad()
    def step(self, closure: Callable[[], float] | None = None) -> float | None:
        """Change every parameter once; see ``torch.optim.Optimizer.step``."""
        groups = self.param_groups
        self.param_groups = [group for group in groups if not group["muon"]]
        try:
            loss = super().step(closure)
        finally:
            self.param_groups = groups
        for group in groups:
            if group["muon"]:
                for value in group["params"]:
                    if value.grad is not None:
                        self._change(value, value.grad, group)
        return loss

    def _change(self, value: Tensor, gradient: Tensor, group: dict[str, Any]) -> None:
        state = self.state[value]
        if not state:
            # AdamW looks for a step in every state that it loads.
            state["step"], state["momentum"] = torch.tensor(0.0), torch.zeros_like(value)
        state["step"] += 1
        momentum = state["momentum"].lerp_(gradient, 1 - group["momentum"])
        update = orthogonalised(gradient.lerp(momentum, group["momentum"]).flatten(1))
        value.mul_(1 - group["lr"] * group["weight_decay"])
        # An entry of the update then has the root mean square that AdamW's usually has.
        scale = 0.2 * max(update.shape) ** 0.5
        value.add_(update.view_as(value).to(value.dtype), alpha=-group["lr"] * scale)


@OptimizerConfig.register_subclass("muon")
@dataclass
class MuonConfig(OptimizerConfig):
    """Settings of :class:`Muon`.

    Attributes:
        lr, weight_decay: of both kinds of parameters.
        betas, eps: AdamW's.
        momentum: Muon's.
        grad_clip_norm: largest norm of all gradients together.
    """

    lr: float = 2e-3
    betas: tuple[float, float] = (0.9, 0.98)
    eps: float = 1e-8
    weight_decay: float = 0.05
    momentum: float = 0.95
    grad_clip_norm: float = 1.0

    def build(self, params: Any) -> Muon:
        """The optimiser of some parameters or parameter groups."""
        return Muon(
            params,
            momentum=self.momentum,
            lr=self.lr,
            betas=self.betas,
            eps=self.eps,
            weight_decay=self.weight_decay,
        )
