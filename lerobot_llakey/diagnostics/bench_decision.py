"""How fast a saved policy decides, as a whole and part by part, and whether its decisions depend on the batch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.utils.collate import lerobot_collate_fn
from torch import Tensor
from torch.nn.functional import normalize

from lerobot_llakey import schema
from lerobot_llakey.diagnostics.bench_policy import DTYPES, against
from lerobot_llakey.diagnostics.bench_timing import in_turns, precision
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import rotation_error
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy
from lerobot_llakey.policies.precision import resolve
from lerobot_llakey.policies.prepared import prepared
from lerobot_llakey.rollout.actors import Agent

Way = Callable[[dict[str, Any]], Any]
PRECISIONS = ("float32", "bfloat16")
"""In which decisions alone and in batches are compared."""


def bench_decision(
    path: str | Path, dataset: LeRobotDataset, steps: int, device: str, dtypes: Sequence[str] = DTYPES
) -> dict[str, Any]:
    """Let a saved policy decide on single samples, one after the other.

    Args:
        path: of its checkpoint; what its settings say of ``dtype`` is what "auto" stands for in the results.
        dataset: keysteps.
        steps: timed decisions.
        device: PyTorch's device.
        dtypes: settings of ``dtype`` that take turns, the one to report first.

    Returns:
        Median milliseconds of the whole decision and of each part, and how many times as long the first ``dtype``
        takes as each other one.
    """
    agent = Agent.load(path, overrides={"device": device})
    rows = _rows(agent, dataset, steps)
    ways = _ways(agent)

    def run(way: Way, dtype: str, number: int) -> None:
        with torch.inference_mode(), precision(agent.policy, dtype):
            way(dict(rows[number % len(rows)]))

    figures: dict[str, Any] = {
        "device": device,
        "threads": torch.get_num_threads(),
        "dtype": f"{dtypes[0]} ({str(resolve(dtypes[0], device)).removeprefix('torch.')})",
    }
    ratios: dict[str, Any] = {}
    for name, way in ways.items():
        timings = in_turns({dtype: partial(run, way, dtype) for dtype in dtypes}, steps, device)
        for dtype, timing in timings.items():
            end = "" if dtype == dtypes[0] else f"_{dtype}"
            figures[f"{name}_milliseconds{end}"] = 1000 * timing.seconds
            figures[f"{name}_processor_milliseconds{end}"] = 1000 * timing.processor_seconds
        ratios |= against(name, timings)
    return figures | ratios


def bench_batch(
    path: str | Path, dataset: LeRobotDataset, samples: int, batch_size: int, device: str
) -> dict[str, Any]:
    """Decide on the same samples alone and in batches, in each of PRECISIONS.

    Args:
        path: of the policy's checkpoint.
        dataset: keysteps, with instructions for the action part.
        samples: how many, spread over the dataset.
        batch_size: of the batches.
        device: PyTorch's device.

    Returns:
        For each precision the mean and greatest difference of positions (millimetres) and rotations (degrees) of the
        action part, how many gripper or collision flags differ, and how many instructions of the command part; and
        the same between the precisions, each row alone.
    """
    agent = Agent.load(path, overrides={"device": device})
    if isinstance(agent.policy, LlakeyCommandPolicy):
        raise LlakeyError(
            f"Expected a policy that acts, of type llakey or llakey_action, got a llakey_command at {path}; compose "
            "it with an action policy."
        )
    rows = _rows(agent, dataset, samples)
    figures: dict[str, Any] = {"device": device, "samples": len(rows), "batch_size": batch_size}
    alone: dict[str, tuple[Tensor, list[str]]] = {}
    for dtype in PRECISIONS:
        with torch.inference_mode(), precision(agent.policy, dtype):
            alone[dtype] = _decide(agent, [[row] for row in rows])
            together = _decide(agent, [rows[i : i + batch_size] for i in range(0, len(rows), batch_size)])
        figures |= _differences(f"{dtype}_alone_against_batch", alone[dtype], together)
    return figures | _differences("float32_against_bfloat16", *(alone[dtype] for dtype in PRECISIONS))


def _rows(agent: Agent, dataset: LeRobotDataset, count: int) -> list[dict[str, Any]]:
    """Batches of one sample each, spread over a dataset, as the policy takes them."""
    if not len(dataset):
        raise LlakeyError("Expected samples to decide on, got an empty dataset; raise --num_episodes.")
    every = max(1, len(dataset) // max(count, 1))
    return [
        prepared(lerobot_collate_fn([dataset[index]]), agent.preprocessor)
        for index in range(0, len(dataset), every)[:count]
    ]


def _ways(agent: Agent) -> dict[str, Way]:
    policy: Any = agent.policy

    def whole(batch: dict[str, Any]) -> Any:
        policy.reset()
        return policy.select_action(batch)

    if not isinstance(policy, LlakeyPolicy):
        return {"decision": policy.next_instructions if hasattr(policy, "next_instructions") else whole}
    ways: dict[str, Way] = {"decision": whole, "action": policy.action.select_action}
    if policy.command is not None:
        ways["command"] = policy.command.next_instructions
    return ways


def _decide(agent: Agent, batches: Sequence[Sequence[dict[str, Any]]]) -> tuple[Tensor, list[str]]:
    """Actions (N, 9) and instructions of the parts that there are, of batches of single rows."""
    ways = _ways(agent)
    act, say = ways.get("action", ways["decision"]), ways.get("command")
    actions: list[Tensor] = []
    said: list[str] = []
    for rows in batches:
        batch = _joined(rows)
        actions.append(act(dict(batch)).float().cpu())
        said += say(dict(batch)) if say is not None else []
    return torch.cat(actions), said


def _joined(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """One batch of single rows."""
    joined: dict[str, Any] = {}
    for key, value in rows[0].items():
        if isinstance(value, Tensor):
            joined[key] = torch.cat([row[key] for row in rows])
        elif isinstance(value, list):
            joined[key] = [text for row in rows for text in row[key]]
    return joined


def _differences(
    name: str, first: tuple[Tensor, list[str]], second: tuple[Tensor, list[str]]
) -> dict[str, float | int]:
    (actions, said), (others, heard) = first, second
    away = 1000 * (actions - others)[:, schema.POSITION].norm(dim=1)
    quaternions = (normalize(each[:, schema.QUATERNION].double(), dim=1) for each in (actions, others))
    turned = rotation_error(*quaternions)
    flags = (actions[:, schema.GRIPPER :] > 0.5) != (others[:, schema.GRIPPER :] > 0.5)
    return {
        f"{name}_mean_mm": away.mean().item(),
        f"{name}_greatest_mm": away.max().item(),
        f"{name}_mean_degrees": turned.mean().item(),
        f"{name}_greatest_degrees": turned.max().item(),
        f"{name}_other_flags": int(flags.sum()),
        f"{name}_other_instructions": sum(one != other for one, other in zip(said, heard, strict=True)),
    }
