"""Work in several processes, here or on the machines of a cluster; none outlives the process that started it."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import wait
from typing import Any

import torch

PROCESSES, RAY = "processes", "ray"
ENGINES = (PROCESSES, RAY)
"""Where jobs run: on this machine's cores, or on a Ray cluster."""
_kept: dict[Callable[..., Any], tuple[tuple[Any, ...], Any]] = {}
_listener: Callable[[Any], None] | None = None


def run_jobs[Result](
    work: Callable[..., Result],
    jobs: Sequence[tuple[Any, ...]],
    num_workers: int = 0,
    hear: Callable[[Any], None] | None = None,
    engine: str = PROCESSES,
) -> Iterator[Result]:
    """Call a module's function with each of the arguments.

    Args:
        work: what to call, a function that other processes can import.
        jobs: its arguments, call by call.
        num_workers: processes; one for each CPU core where 0, none but this one where 1.
        hear: called here with whatever the calls :func:`tell` on their way.
        engine: out of ENGINES. On a Ray cluster, jobs are heard of as they end, and a job whose process or machine
            dies is begun again.

    Yields:
        What the calls return, in the order in which they end.
    """
    global _listener
    if engine == RAY:
        from lerobot_llakey.ray_engine import run_on_ray

        yield from run_on_ray(work, jobs, num_workers, hear, _listened)
        return
    workers = min(count_workers(num_workers), len(jobs))
    if workers <= 1:
        _listener = hear
        try:
            for job in jobs:
                yield work(*job)
        finally:
            _listener = None
        return
    told = None if hear is None else get_context("spawn").SimpleQueue()
    if told is not None:
        listening = threading.Thread(target=_hear, args=(told, hear), daemon=True)
        listening.start()
    with process_pool(workers, told) as pool:
        try:
            for future in as_completed([pool.submit(work, *job) for job in jobs]):
                yield future.result()
        except BaseException as error:
            pool.shutdown(wait=False, cancel_futures=True)  # an error is told now, not after all other jobs
            if isinstance(error, KeyboardInterrupt):  # nor after those that are under way
                for process in active_children():
                    process.terminate()
            raise
    if told is not None:
        told.put(None)
        listening.join()


def count_workers(num_workers: int, engine: str = PROCESSES) -> int:
    """How many jobs can run at a time, where 0 workers are as many as there are CPUs."""
    if engine == RAY and not num_workers:
        from lerobot_llakey.ray_engine import count_cpus

        return count_cpus()
    return num_workers or os.cpu_count() or 1


def tell(news: Any) -> None:
    """Tell whoever runs this job how it goes; nothing where nobody wants to hear of it, or None is told."""
    if _listener is not None and news is not None:
        _listener(news)


def process_pool(workers: int, told: Any = None) -> ProcessPoolExecutor:
    """Fresh processes: OpenGL contexts and PyTorch's threads do not survive a fork.

    Args:
        workers: how many.
        told: a queue for what they :func:`tell`.
    """
    return ProcessPoolExecutor(workers, get_context("spawn"), _begin, (told,))


def end_with_parent(end: Callable[[], None]) -> None:
    """Call a function once the process that started this one ends, also where it is killed."""
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel, end), daemon=True).start()


def kept[Made](make: Callable[..., Made], *arguments: Any) -> Made:
    """What a function returns, the last of it kept in this process for whoever asks for the same again.

    Jobs come in blocks that need the same policy or scene. What can be closed is closed once another takes its place.
    """
    if make in _kept and _kept[make][0] != arguments:
        old = _kept.pop(make)[1]
        if hasattr(old, "close"):
            old.close()
    if make not in _kept:
        _kept[make] = arguments, make(*arguments)
    made: Made = _kept[make][1]
    return made


def _begin(told: Any) -> None:
    """What a process does first: one thread, no life after the process that started it, and Ctrl-C is left to that."""
    global _listener
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    torch.set_num_threads(1)
    end_with_parent(lambda: os._exit(1))  # a pool's processes would wait for it for ever
    _listener = None if told is None else told.put


def _listened[Result](work: Callable[..., Result], job: tuple[Any, ...]) -> tuple[Result, list[Any]]:
    """Do a job in a process that another engine has started: what it returns and what it told."""
    global _listener
    torch.set_num_threads(1)
    told: list[Any] = []
    _listener = told.append
    try:
        return work(*job), told
    finally:
        _listener = None


def _end_with(sentinel: int, end: Callable[[], None]) -> None:
    wait([sentinel])
    end()


def _hear(told: Any, hear: Callable[[Any], None]) -> None:
    while (news := told.get()) is not None:
        hear(news)
