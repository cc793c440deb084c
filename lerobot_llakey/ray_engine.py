"""Jobs on the machines of a Ray cluster."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from lerobot_llakey.errors import LlakeyError

ATTEMPTS = 5
"""Times that a job is begun again because its process or its machine died; then the job itself is at fault."""


def run_on_ray[Result](
    work: Callable[..., Result],
    jobs: Sequence[tuple[Any, ...]],
    num_workers: int,
    hear: Callable[[Any], None] | None,
    listened: Callable[[Callable[..., Result], tuple[Any, ...]], tuple[Result, list[Any]]],
) -> Iterator[Result]:
    """As :func:`lerobot_llakey.parallel.run_jobs`, on the cluster that is running here or at ``RAY_ADDRESS``.

    A job whose process or machine dies is begun again elsewhere, so it must bear being done once and a bit. What it
    tells is heard when it has ended, so that nothing is heard twice.

    Args:
        work: what to call, a function that the machines can import.
        jobs: its arguments, call by call.
        num_workers: jobs under way at a time; as many as the cluster has CPUs where 0.
        hear: called here with whatever the calls tell.
        listened: calls ``work`` in a job's process; returns its result and what it told.

    Raises:
        LlakeyError: if Ray is not installed, there is no cluster, or a job's processes keep dying.
    """
    ray = _connected()
    remote = ray.remote(num_cpus=1, max_retries=ATTEMPTS)(_do)
    waiting, running = list(reversed(jobs)), set[Any]()
    try:
        while waiting or running:
            while waiting and (not num_workers or len(running) < num_workers):
                running.add(remote.remote(listened, work, waiting.pop(), str(Path.cwd())))
            (ended, *_), _ = ray.wait(list(running))
            running.remove(ended)
            result, told = _fetch(ray, ended)
            if hear is not None:
                for news in told:
                    hear(news)
            yield result
    finally:
        for job in running:  # an error is told now, not after all other jobs
            ray.cancel(job, force=True)


def count_cpus() -> int:
    """Of the whole cluster, and one at the least.

    Raises:
        LlakeyError: as in :func:`run_on_ray`.
    """
    return max(1, int(_connected().cluster_resources().get("CPU", 1)))


def _do(listened: Callable[..., Any], work: Callable[..., Any], job: tuple[Any, ...], folder: str) -> Any:
    """What a job's process does: relative paths mean there what they mean here."""
    try:
        os.chdir(folder)
    except OSError as error:
        raise LlakeyError(
            f"Expected the folder {folder} on every machine of the cluster, got {os.uname().nodename} without it; run "
            "from a folder that all share."
        ) from error
    return listened(work, job)


def _fetch(ray: ModuleType, ended: Any) -> Any:
    """A job's result, or the error that it ended with."""
    try:
        return ray.get(ended)
    except ray.exceptions.RayTaskError as error:
        if isinstance(error.cause, Exception):
            raise error.cause from None
        raise
    except ray.exceptions.RayError as error:  # its process, its machine or the memory for its result is gone
        raise LlakeyError(
            f"Expected the processes on the Ray cluster to live until their jobs are done, got one that died again and "
            f"again ({type(error).__name__}); look at its machine's memory and run the command again: what is finished "
            "is kept."
        ) from error


def _connected() -> ModuleType:
    try:
        import ray
    except ImportError as error:
        raise LlakeyError(
            "Expected Ray for --engine=ray, got none installed; pip install 'lerobot_policy_llakey[ray]'."
        ) from error
    if not ray.is_initialized():
        try:
            ray.init("auto", log_to_driver=False, logging_level=logging.ERROR)
        except (ConnectionError, ValueError, RuntimeError) as error:
            raise LlakeyError(
                f"Expected a running Ray cluster, got none ({type(error).__name__}); start it with ray start --head, "
                "or name it in RAY_ADDRESS."
            ) from error
    return ray
