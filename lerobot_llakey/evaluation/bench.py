"""Benchmarks: how fast demonstrations are written, samples loaded, policies trained and decisions made.

Each part measures everything that it compares in one run on one machine, and reports the machine with the figures.
"""

from __future__ import annotations

import os
import platform
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.policies.factory import make_policy, make_policy_config, make_pre_post_processors
from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.utils.collate import lerobot_collate_fn
from torch.utils.data import DataLoader
from tqdm import tqdm

from lerobot_llakey.datasets.collect import collect
from lerobot_llakey.datasets.plan import CollectSettings, Targets
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
        raise ValueError(f"Expected a part out of {', '.join(PARTS)}, got {part!r}; correct --part.")
    if min(num_episodes, batch_size, steps) < 1:
        raise ValueError(
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
        return {**machine(), **_bench_loader(dataset, batch_size, steps)}
    return {**machine(), **_bench_policy(_POLICIES[part], dataset, batch_size, steps, device)}


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


def _bench_loader(dataset: LeRobotDataset, batch_size: int, steps: int) -> dict[str, Any]:
    figures: dict[str, Any] = {"batch_size": batch_size}
    for workers in (0, 1, 2):
        loader = DataLoader(
            dataset, batch_size, shuffle=True, drop_last=True, num_workers=workers, collate_fn=lerobot_collate_fn
        )
        batches = _endless(loader)
        next(batches)
        start = time.perf_counter()
        for _ in range(steps):
            next(batches)
        figures[f"samples_per_second_{workers}_workers"] = steps * batch_size / (time.perf_counter() - start)
    return figures


def _bench_policy(kind: str, dataset: LeRobotDataset, batch_size: int, steps: int, device: str) -> dict[str, Any]:
    config = make_policy_config(kind, device=device, push_to_hub=False)
    policy = make_policy(config, ds_meta=dataset.meta)
    preprocessor, _ = make_pre_post_processors(config, dataset_stats=dataset.meta.stats)
    loader = DataLoader(dataset, batch_size, shuffle=True, drop_last=True, collate_fn=lerobot_collate_fn)
    batch = preprocessor(next(iter(loader)))
    alone = preprocessor(lerobot_collate_fn([dataset[0]]))
    optimizer = config.get_optimizer_preset().build(policy.get_optim_params())
    policy.train()
    train = _median_seconds(lambda: _train_step(policy, batch, optimizer), steps, device)
    policy.eval()
    decide = _median_seconds(lambda: _decide(policy, alone), steps, device)
    return {
        "policy": kind,
        "device": device,
        "threads": torch.get_num_threads(),
        "parameters": sum(parameter.numel() for parameter in policy.parameters()),
        "batch_size": batch_size,
        "training_samples_per_second": batch_size / train,
        "decision_milliseconds": 1000 * decide,
    }


def _train_step(policy: PreTrainedPolicy, batch: dict[str, Any], optimizer: torch.optim.Optimizer) -> None:
    loss, _ = policy.forward(dict(batch))
    loss.backward()
    optimizer.step()
    optimizer.zero_grad()


def _decide(policy: PreTrainedPolicy, batch: dict[str, Any]) -> None:
    policy.reset()
    with torch.inference_mode():
        if hasattr(policy, "next_instructions"):
            policy.next_instructions(dict(batch))
        else:
            policy.select_action(dict(batch))


def _median_seconds(action: Callable[[], None], repeats: int, device: str) -> float:
    times = []
    for repeat in tqdm(range(repeats + 2), leave=False):
        start = time.perf_counter()
        action()
        if device.startswith("cuda"):
            torch.cuda.synchronize()
        if repeat >= 2:  # the first ones warm up
            times.append(time.perf_counter() - start)
    return statistics.median(times)


def _endless(loader: DataLoader) -> Any:
    while True:
        yield from loader


def bench_in_temporary_folder(part: str, num_episodes: int, batch_size: int, steps: int, device: str) -> dict[str, Any]:
    """:func:`bench` with datasets that are thrown away afterwards."""
    with TemporaryDirectory() as folder:
        return bench(part, num_episodes, batch_size, steps, device, Path(folder))
