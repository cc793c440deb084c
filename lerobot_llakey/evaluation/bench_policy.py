"""How fast a policy is trained, and how fast it decides."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import Any

import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.policies.factory import make_policy, make_policy_config, make_pre_post_processors
from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.utils.collate import lerobot_collate_fn
from torch.utils.data import DataLoader
from tqdm import tqdm

_WARM_UP = 2


def bench_policy(
    kind: str, dataset: LeRobotDataset, batch_size: int, steps: int, device: str, **settings: Any
) -> dict[str, Any]:
    """Train a fresh policy on one batch again and again, then let it decide on one sample.

    Args:
        kind: the policy's type.
        dataset: keysteps.
        batch_size: samples a training step.
        steps: timed repetitions, of which the median is taken.
        device: PyTorch's device.
        settings: of the policy, where they are not its defaults.
    """
    config = make_policy_config(kind, device=device, push_to_hub=False, **settings)
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
    for repeat in tqdm(range(repeats + _WARM_UP), leave=False):
        start = time.perf_counter()
        action()
        if device.startswith("cuda"):
            torch.cuda.synchronize()
        if repeat >= _WARM_UP:
            times.append(time.perf_counter() - start)
    return statistics.median(times)
