"""What training draws at random, so that a seed repeats it and a resumed run goes on with it.

LeRobot seeds the generators of Python, NumPy and PyTorch with ``--seed`` and keeps their states in a checkpoint. But
PyTorch's ``DataLoader`` draws from PyTorch's generator whenever it starts over its dataset, and so once more where a
run is resumed. Hence each step takes one number from Python's generator, and that is the seed of all that it draws.
"""

from __future__ import annotations

import functools
import random
from collections.abc import Callable
from typing import Any

import numpy as np
import torch


def seeded_by_step[**P, R](forward: Callable[P, R]) -> Callable[P, R]:
    """A policy's ``forward`` whose draws in training have a seed of their own, see above.

    PyTorch's generators are afterwards as they were. Outside training nothing is drawn or changed.
    """

    @functools.wraps(forward)
    def seeded(*args: P.args, **kwargs: P.kwargs) -> R:
        policy: Any = args[0]
        if not policy.training:
            return forward(*args, **kwargs)
        device = next((value.device for value in policy.parameters()), torch.device("cpu"))
        # On Apple's GPUs PyTorch cannot put one device's generator aside; there it is seeded all the same.
        aside = [device] if device.type in ("cuda", "xpu") else []
        with torch.random.fork_rng(aside, device_type=device.type if aside else "cuda"):
            torch.manual_seed(random.getrandbits(63))
            return forward(*args, **kwargs)

    return seeded


def numpy_generator() -> np.random.Generator:
    """A generator for draws with NumPy, seeded by PyTorch's."""
    return np.random.default_rng(int(torch.randint(2**63 - 1, ())))
