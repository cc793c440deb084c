"""A Ray cluster of two nodes on this machine, of which processes and nodes are killed while it collects."""

from __future__ import annotations

import os
import random
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from lerobot_llakey.datasets.collect import collect
from lerobot_llakey.datasets.digest import digest
from lerobot_llakey.datasets.plan import CollectSettings, Targets
from lerobot_llakey.parallel import RAY
from torture.kills import Outcome

_NODE = {"num_cpus": 1, "object_store_memory": 80 << 20}


@contextmanager
def two_nodes() -> Iterator[Any]:
    """A cluster, connected to; its head holds jobs, too."""
    os.environ |= {"RAY_USAGE_STATS_ENABLED": "0", "RAY_ENABLE_UV_RUN_RUNTIME_ENV": "0"}
    import ray
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args=_NODE | {"include_dashboard": False})
    try:
        cluster.add_node(**_NODE)
        ray.init(cluster.address, log_to_driver=False, logging_level="ERROR")
        yield cluster
    finally:
        ray.shutdown()
        cluster.shutdown()


def job_processes() -> list[int]:
    """Processes that hold a job now, of the nodes that this process started."""
    return [pid for pid in map(int, filter(str.isdigit, os.listdir("/proc"))) if _holds_job(pid)]


def _holds_job(pid: int) -> bool:
    try:
        if not Path(f"/proc/{pid}/cmdline").read_bytes().startswith(b"ray::_do"):
            return False
        while pid > 1 and pid != os.getpid():
            pid = int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])
    except OSError:
        return False
    return pid == os.getpid()


def kill_on_cluster(
    cluster: Any, folder: Path, repeats: int, seed: int, settings: CollectSettings, longest: float = 3.0
) -> Outcome:
    """Collect on the cluster, each time with a process, and every second time with a whole node, killed midway.

    Args:
        cluster: of two nodes.
        folder: to work in.
        repeats: collections.
        seed: of the moments, and of which process dies.
        settings: of the collections.
        longest: seconds from the first episode's beginning to the kill.
    """
    rng, outcome = random.Random(seed), Outcome()
    whole = Targets(None, folder / "whole")
    collect(settings, whole, 1, progress=_quiet)
    assert whole.keysteps is not None
    expected = digest(whole.keysteps)
    for repeat in range(repeats):
        targets = Targets(None, folder / str(repeat))
        assert targets.keysteps is not None
        told: list[int] = []
        killer = threading.Thread(
            target=_kill, args=(cluster, Path(f"{targets.keysteps}.parts"), rng, bool(repeat % 2), longest, outcome)
        )
        killer.start()
        try:
            collect(settings, targets, 2, progress=lambda kept, _, told=told: told.append(kept), engine=RAY)
        except Exception as error:  # counted
            outcome.broken.append(f"{type(error).__name__}: {str(error)[:300]}")
        killer.join()
        outcome.runs += 1
        if not targets.keysteps.exists() or digest(targets.keysteps) != expected:
            outcome.differing.append(str(targets.keysteps))
        if sum(told) != len(settings):
            outcome.broken.append(f"heard of {sum(told)} episodes in place of {len(settings)}")
    return outcome


def _quiet(*_: int) -> None:
    """No bar."""


def _kill(cluster: Any, parts: Path, rng: random.Random, node: bool, longest: float, outcome: Outcome) -> None:
    delay = rng.uniform(0, longest)
    while not list(parts.glob("unfinished-*")):
        time.sleep(0.01)
    time.sleep(delay)
    outcome.parts += len([path for path in parts.glob("*") if path.name[0].isdigit()])
    if node:
        cluster.remove_node(next(iter(cluster.worker_nodes)), allow_graceful=False)
        outcome.kills += 1
        cluster.add_node(**_NODE)
        return
    while parts.exists():
        if running := job_processes():
            os.kill(rng.choice(sorted(running)), signal.SIGKILL)
            outcome.kills += 1
            return
        time.sleep(0.01)
