"""Benchmarks: how fast demonstrations are written, samples loaded, policies trained and decisions made.

Each part measures everything that it compares in one run on one machine, and reports the machine with the figures.
"""

from __future__ import annotations

import os
import platform
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey.datasets.collect import collect
from lerobot_llakey.datasets.plan import CollectSettings, Targets
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.bench_loader import bench_loader
from lerobot_llakey.evaluation.bench_policy import bench_policy
from lerobot_llakey.evaluation.bench_render import bench_render
from lerobot_llakey.sim.tasks import task_classes

PARTS = ("collect", "loader", "render", "action", "command")
TASKS = ("open_drawer", "close_jar", "move_block")
"""What samples are taken from to measure loading, training and deciding; collecting is measured on all tasks."""
_POLICIES = {"action": "llakey_action", "command": "llakey_command"}


def bench(part: str, num_episodes: int, batch_size: int, steps: int, device: str, workdir: Path) -> dict[str, Any]:
    """Measure one part.

    Args:
        part: one of PARTS.
        num_episodes: episodes of each task to collect: of all tasks, timed, for "collect", of TASKS otherwise.
        batch_size: samples a training step.
        steps: timed repetitions of a step or decision.
        device: PyTorch's device for the policies.
        workdir: an empty folder for the datasets that are made.

    Returns:
        Figures by name, with the machine.

    Raises:
        ValueError: if the part is unknown or a number is not positive.
    """
    if part not in PARTS:
        raise LlakeyError(f"Expected a part out of {', '.join(PARTS)}, got {part!r}; correct --part.")
    if min(num_episodes, batch_size, steps) < 1:
        raise LlakeyError(
            f"Expected num_episodes, batch_size and steps of 1 or more, got {num_episodes}, {batch_size} and {steps}."
        )
    if part == "collect":
        return {**machine(), **_bench_collect(CollectSettings(tuple(task_classes()), num_episodes), workdir)}
    if part == "render":
        return {**machine(), **bench_render(steps, device)}
    settings = CollectSettings(TASKS, num_episodes)
    collect(settings, Targets(None, workdir / "keysteps", keysteps_id="bench/keysteps"))
    dataset = LeRobotDataset("bench/keysteps", root=workdir / "keysteps")
    if part == "loader":
        return {**machine(), **bench_loader(dataset, batch_size, steps, device)}
    return {**machine(), **bench_policy(_POLICIES[part], dataset, batch_size, steps, device)}


def machine() -> dict[str, Any]:
    """What the figures were measured on."""
    return {
        "processor": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "gpu": torch.cuda.get_device_name() if torch.cuda.is_available() else None,
        "torch": torch.__version__,
    }


def _bench_collect(settings: CollectSettings, workdir: Path) -> dict[str, Any]:
    both = {
        "demonstrations": Targets(workdir / "demonstrations", None, demonstrations_id="bench/demonstrations"),
        "keysteps": Targets(None, workdir / "keysteps", keysteps_id="bench/keysteps"),
    }
    figures: dict[str, Any] = {"episodes": len(settings)}
    for name, targets in both.items():
        start = time.perf_counter()
        collect(settings, targets)
        minutes = (time.perf_counter() - start) / 60
        figures[f"{name}_episodes_per_minute"] = len(settings) / minutes
        size = sum(file.stat().st_size for file in (workdir / name).rglob("*") if file.is_file())
        figures[f"{name}_megabytes_per_episode"] = size / len(settings) / 1e6
        figures[f"{name}_gigabytes_for_100_of_each_task"] = size / settings.num_episodes * 100 / 1e9
    return figures


def bench_in_temporary_folder(part: str, num_episodes: int, batch_size: int, steps: int, device: str) -> dict[str, Any]:
    """:func:`bench` with datasets that are thrown away afterwards."""
    with TemporaryDirectory() as folder:
        return bench(part, num_episodes, batch_size, steps, device, Path(folder))
