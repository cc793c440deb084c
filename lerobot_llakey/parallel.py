"""Running many episodes in several processes, each of which keeps the scenes that it has compiled."""

from __future__ import annotations

import functools
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import wait
from typing import Any

import torch

from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task


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
    with ProcessPoolExecutor(workers, get_context("spawn"), _begin) as pool:
        try:
            for future in as_completed([pool.submit(work, *job) for job in jobs]):
                yield future.result()
        except BaseException as error:
            pool.shutdown(wait=False, cancel_futures=True)  # an error is told now, not after all other jobs
            if isinstance(error, KeyboardInterrupt):  # nor after those that are under way
                for process in active_children():
                    process.terminate()
            raise


def _begin() -> None:
    """What a process does first: one thread, no life after the process that started it, and Ctrl-C is left to that."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    torch.set_num_threads(1)
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    """Wait for the starting process to end, also where it is killed; a pool's processes would wait for it for ever."""
    wait([sentinel])
    os._exit(1)


@functools.cache
def simulation_of(task: str) -> Simulation:
    """The simulation of a task, built once in each process."""
    return Simulation(make_task(task))
