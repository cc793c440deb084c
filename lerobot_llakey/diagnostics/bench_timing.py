"""Timing several ways to do a thing in turns, so that whatever else runs on the machine disturbs all of them."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

import torch
from lerobot.policies.pretrained import PreTrainedPolicy
from tqdm import tqdm

_WARM_UP = 2


@dataclass(frozen=True)
class Timing:
    """Medians over the repetitions of one way.

    Attributes:
        seconds: by the clock.
        processor_seconds: of all threads on the processor, which other processes hardly change.
    """

    seconds: float
    processor_seconds: float


def in_turns(ways: Mapping[str, Callable[[int], object]], repeats: int, device: str) -> dict[str, Timing]:
    """Time each way as often.

    Args:
        ways: by name, called with the number of the repetition.
        repeats: timed ones, after a warm-up.
        device: PyTorch's device, waited for.
    """
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    for repeat in tqdm(range(-_WARM_UP, repeats), leave=False):
        for name, way in ways.items():
            start, processor_start = time.perf_counter(), time.process_time()
            way(repeat)
            if device.startswith("cuda"):
                torch.cuda.synchronize()
            if repeat >= 0:
                times[name].append((time.perf_counter() - start, time.process_time() - processor_start))
    return {
        name: Timing(*(statistics.median(column) for column in zip(*measured, strict=True)))
        for name, measured in times.items()
    }


@contextmanager
def precision(policy: PreTrainedPolicy, dtype: str) -> Iterator[None]:
    """Let a policy and its parts compute with another ``dtype`` setting within the block."""
    parts = [part for part in policy.modules() if isinstance(part, PreTrainedPolicy) and hasattr(part.config, "dtype")]
    saved = [part.config.dtype for part in parts]
    for part in parts:
        part.config.dtype = dtype
    try:
        yield
    finally:
        for part, value in zip(parts, saved, strict=True):
            part.config.dtype = value
