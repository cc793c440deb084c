"""Running many episodes in several processes, each of which keeps the scenes that it has compiled."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Any

import torch

from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.world import World


def run_jobs[Result](
    work: Callable[..., Result], jobs: Sequence[tuple[Any, ...]], num_workers: int = 0
) -> Iterator[Result]:
    """Call a module's function with each of the arguments.

    Args:
        work: what to call, a function that other processes can import.
        jobs: its arguments, call by call.
        num_workers: processes; one for each CPU core where 0, none but this one where 1.

    Yields:
        What the calls return, in the order in which they end.
    """
    workers = min(num_workers or os.cpu_count() or 1, len(jobs))
    if workers <= 1:
        for job in jobs:
            yield work(*job)
        return
    # Fresh processes: OpenGL contexts and PyTorch's threads do not survive a fork.
    with ProcessPoolExecutor(workers, get_context("spawn"), torch.set_num_threads, (1,)) as pool:
        for future in as_completed([pool.submit(work, *job) for job in jobs]):
            yield future.result()


@functools.cache
def world_of(task: str) -> World:
    """The scene of a task, built once in each process."""
    return World(make_task(task))
