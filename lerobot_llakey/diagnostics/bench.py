"""Benchmarks: how fast demonstrations are written, samples loaded, policies trained and decisions made.

Each part measures everything that it compares in one run on one machine, and reports the machine with the figures.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey.bounds import require_count
from lerobot_llakey.datasets.collect import collect
from lerobot_llakey.datasets.plan import CollectSettings, Targets
from lerobot_llakey.diagnostics.bench_decision import bench_batch, bench_decision
from lerobot_llakey.diagnostics.bench_loader import bench_loader
from lerobot_llakey.diagnostics.bench_policy import bench_policy
from lerobot_llakey.diagnostics.bench_render import bench_render
from lerobot_llakey.diagnostics.processor import load, machine
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.tasks import task_classes

PARTS = ("collect", "loader", "render", "action", "command", "decision", "batch")
TASKS = ("open_drawer", "close_jar", "move_block")
"""What samples are taken from to measure loading, training and deciding; collecting is measured on all tasks."""
_POLICIES = {"action": "llakey_action", "command": "llakey_command"}
_SAVED = ("decision", "batch")
"""Parts that measure a saved policy."""


@dataclass(frozen=True)
class BenchSettings:
    """What to measure.

    Attributes:
        part: one of PARTS.
        num_episodes: episodes of each task to collect: of all tasks, timed, for "collect", of TASKS otherwise.
        batch_size: samples a training step; for "batch", those decided on together.
        steps: timed repetitions of a step or decision.
        device: PyTorch's device for the policies.
        policy_path: checkpoint of the policy to measure, for "decision" and "batch".
        samples: for "batch", how many are decided on.
        bfloat16: measure bfloat16 too where it is not the choice anyway; on a processor without units for it one
            training step takes a minute.
        dataset_root: folder of keysteps to measure on; None collects some.

    Raises:
        LlakeyError: if the part is unknown, a number is not positive, or a path is missing.
    """

    part: str
    num_episodes: int = 4
    batch_size: int = 16
    steps: int = 10
    device: str = "cpu"
    policy_path: str | None = None
    samples: int = 64
    bfloat16: bool = False
    dataset_root: Path | None = None

    def __post_init__(self) -> None:
        if self.part not in PARTS:
            raise LlakeyError(f"Expected a part out of {', '.join(PARTS)}, got {self.part!r}; correct --part.")
        for name in ("num_episodes", "batch_size", "steps", "samples"):
            require_count(f"--{name}", getattr(self, name), 1)
        if self.part in _SAVED and not self.policy_path:
            raise LlakeyError(
                f"Expected the policy's checkpoint for --part={self.part}, got none; name it with --policy_path."
            )
        if self.part not in _SAVED and self.policy_path is not None:
            raise LlakeyError(
                f"Expected --policy_path with --part={' or '.join(_SAVED)} alone, got {self.policy_path!r} with "
                f"--part={self.part}; leave it out."
            )

    @property
    def dtypes(self) -> tuple[str, ...]:
        """The settings of ``dtype`` that take turns."""
        return ("auto", "float32", *(("bfloat16",) if self.bfloat16 else ()))


def bench(settings: BenchSettings, workdir: Path) -> dict[str, Any]:
    """Measure one part.

    Args:
        settings: what to measure.
        workdir: an empty folder for the datasets that are made.

    Returns:
        The machine, figures by name, and how busy the machine was in the last minute before and at the end.
    """
    before = load()
    figures = _figures(settings, workdir)
    return {**machine(), **figures, "load_before": before, "load_at_the_end": load()}


def _figures(settings: BenchSettings, workdir: Path) -> dict[str, Any]:
    part, steps, device = settings.part, settings.steps, settings.device
    if part == "collect":
        return _bench_collect(CollectSettings(tuple(task_classes()), settings.num_episodes), workdir)
    if part == "render":
        return bench_render(steps, device)
    root = settings.dataset_root
    if root is None:
        root = workdir / "keysteps"
        collect(CollectSettings(TASKS, settings.num_episodes), Targets(None, root, keysteps_id="bench/keysteps"))
    dataset = LeRobotDataset("bench/keysteps", root=root)
    if part == "loader":
        return bench_loader(dataset, settings.batch_size, steps, device)
    if part in _POLICIES:
        return bench_policy(_POLICIES[part], dataset, settings.batch_size, steps, device, settings.dtypes)
    assert settings.policy_path is not None
    if part == "batch":
        return bench_batch(settings.policy_path, dataset, settings.samples, settings.batch_size, device)
    return bench_decision(settings.policy_path, dataset, steps, device, settings.dtypes)


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


def bench_in_temporary_folder(settings: BenchSettings) -> dict[str, Any]:
    """:func:`bench` with datasets that are deleted afterwards."""
    with TemporaryDirectory() as folder:
        return bench(settings, Path(folder))
