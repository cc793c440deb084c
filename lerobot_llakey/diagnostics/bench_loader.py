"""Whether samples are loaded faster than the action policy is trained on them, and what their loading costs."""

from __future__ import annotations

import os
import time
from collections.abc import Iterable
from typing import Any

import datasets
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.utils.collate import lerobot_collate_fn
from torch.utils.data import DataLoader, RandomSampler

from lerobot_llakey.diagnostics.bench_policy import bench_policy

WORKERS = (0, 1, 2, 4, 8, 16)
"""Numbers of the loader's processes that are measured, as far as the machine has cores."""
_PROFILED = 200
"""Samples at most whose loading is taken apart."""


def bench_loader(dataset: LeRobotDataset, batch_size: int, steps: int, device: str) -> dict[str, Any]:
    """Load samples alone, then train the action policy's defaults alone, as often on one machine.

    Args:
        dataset: keysteps, whose pictures are PNGs.
        batch_size: samples a batch, in loading and training.
        steps: timed batches.
        device: PyTorch's device for the policy.

    Returns:
        Samples a second of the loader with each number of workers; those of training; for each number of workers how
        many times faster loading is than training; and what :func:`loading_cost` says.
    """
    cores = os.cpu_count() or 1
    loading = {
        workers: loading_speed(dataset, batch_size, steps, workers)
        for workers in WORKERS
        if workers <= cores or workers <= 1
    }
    training = bench_policy("llakey_action", dataset, batch_size, steps, device, dtypes=("auto",))
    figures = {key: training[key] for key in ("batch_size", "device", "threads", "training_samples_per_second")}
    for workers, speed in loading.items():
        figures[f"samples_per_second_{workers}_workers"] = speed
        figures[f"loading_to_training_{workers}_workers"] = speed / training["training_samples_per_second"]
    return figures | loading_cost(dataset, range(0, len(dataset), -(-len(dataset) // _PROFILED)))


def loading_speed(dataset: LeRobotDataset, batch_size: int, steps: int, workers: int) -> float:
    """Samples a second of random batches, once what the workers prefetched while they started is used up."""
    warm_up = 1 + 2 * workers
    sampler = RandomSampler(dataset, replacement=True, num_samples=batch_size * (warm_up + steps))
    batches = iter(DataLoader(dataset, batch_size, sampler=sampler, num_workers=workers, collate_fn=lerobot_collate_fn))
    for _ in range(warm_up):
        next(batches)
    start = time.perf_counter()
    for _ in range(steps):
        next(batches)
    return steps * batch_size / (time.perf_counter() - start)


def loading_cost(dataset: LeRobotDataset, indices: Iterable[int]) -> dict[str, float]:
    """What a sample costs to load in one process.

    Args:
        dataset: whose pictures lie in its table.
        indices: of the samples.

    Returns:
        ``processor_milliseconds_per_sample`` of the whole loading and ``decoding_share`` of it that turns the
        pictures' bytes into pixels. Both are the processor's time, so that other processes do not count.
    """
    rows, picture = list(indices), datasets.Image()
    table = dataset.hf_dataset.with_format("arrow")
    keys = [key for key, feature in table.features.items() if isinstance(feature, datasets.Image)]
    whole = decoding = 0.0
    for row in rows:
        stored = [table[row][key][0].as_py() for key in keys]
        start = time.process_time()
        for value in stored:
            picture.decode_example(value)
        decoding += time.process_time() - start
        start = time.process_time()
        dataset[row]
        whole += time.process_time() - start
    return {"processor_milliseconds_per_sample": 1000 * whole / len(rows), "decoding_share": decoding / whole}
