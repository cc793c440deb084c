"""How fast a policy is trained, and how fast it decides: as shipped and in other precisions, in turns."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.policies.factory import make_policy, make_policy_config, make_pre_post_processors
from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.utils.collate import lerobot_collate_fn
from torch.utils.data import DataLoader

from lerobot_llakey.diagnostics.bench_timing import Timing, in_turns, precision
from lerobot_llakey.policies.precision import resolve
from lerobot_llakey.policies.prepared import prepared

DTYPES = ("auto", "float32")
"""Settings of ``dtype`` to compare: what is shipped comes first."""


def bench_policy(
    kind: str,
    dataset: LeRobotDataset,
    batch_size: int,
    steps: int,
    device: str,
    dtypes: Sequence[str] = DTYPES,
    **settings: Any,
) -> dict[str, Any]:
    """Train a fresh policy on one batch again and again, then let it decide on one sample.

    Args:
        kind: the policy's type.
        dataset: keysteps.
        batch_size: samples a training step.
        steps: timed repetitions, of which the median is taken.
        device: PyTorch's device.
        dtypes: settings of ``dtype`` that take turns, the one to report first.
        settings: of the policy, where they are not its defaults.

    Returns:
        Speeds of the first ``dtype``, then for each other one its speeds and :func:`against`.
    """
    config = make_policy_config(kind, device=device, push_to_hub=False, **settings)
    policy = make_policy(config, ds_meta=dataset.meta)
    preprocessor, _ = make_pre_post_processors(config, dataset_stats=dataset.meta.stats)
    loader = DataLoader(dataset, batch_size, shuffle=True, drop_last=True, collate_fn=lerobot_collate_fn)
    batch = prepared(next(iter(loader)), preprocessor)
    alone = prepared(lerobot_collate_fn([dataset[0]]), preprocessor)
    optimizer = config.get_optimizer_preset().build(policy.get_optim_params())

    def train(dtype: str, _: int) -> None:
        with precision(policy, dtype):
            loss, _ = policy.forward(dict(batch))
            loss.backward()
        optimizer.step()
        optimizer.zero_grad()

    def decide(dtype: str, _: int) -> None:
        with precision(policy, dtype):
            _decide(policy, alone)

    policy.train()
    trained = in_turns({dtype: partial(train, dtype) for dtype in dtypes}, steps, device)
    policy.eval()
    decided = in_turns({dtype: partial(decide, dtype) for dtype in dtypes}, steps, device)
    figures: dict[str, Any] = {
        "policy": kind,
        "device": device,
        "threads": torch.get_num_threads(),
        "parameters": sum(parameter.numel() for parameter in policy.parameters()),
        "batch_size": batch_size,
        "dtype": f"{dtypes[0]} ({str(resolve(dtypes[0], device)).removeprefix('torch.')})",
    }
    for dtype in dtypes:
        end = "" if dtype == dtypes[0] else f"_{dtype}"
        figures[f"training_samples_per_second{end}"] = batch_size / trained[dtype].seconds
        figures[f"decision_milliseconds{end}"] = 1000 * decided[dtype].seconds
    return figures | against("training_step", trained) | against("decision", decided)


def against(what: str, timings: dict[str, Timing]) -> dict[str, float]:
    """How many times as long the first way takes as each other one, by the clock and on the processor."""
    (_, first), *others = timings.items()
    ratios: dict[str, float] = {}
    for name, other in others:
        ratios[f"{what}_time_against_{name}"] = first.seconds / other.seconds
        ratios[f"{what}_processor_time_against_{name}"] = first.processor_seconds / other.processor_seconds
    return ratios


def _decide(policy: PreTrainedPolicy, batch: dict[str, Any]) -> None:
    policy.reset()
    with torch.inference_mode():
        if hasattr(policy, "next_instructions"):
            policy.next_instructions(dict(batch))
        else:
            policy.select_action(dict(batch))
