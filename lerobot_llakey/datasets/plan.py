"""What to collect and where to: settings that fix every episode beforehand."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.bounds import require_count, require_number
from lerobot_llakey.datasets.balance import PAPER, Balance
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.perturbations.registry import EVENTS, EXECUTION_NOISE
from lerobot_llakey.sim.scene import TIMESTEP

ATTEMPTS = 10
"""Scenes tried for an episode before giving up: an expert that fails this often in a row is broken."""
IMAGE_SIZES = (16, 960)
"""Smallest and largest height and width of pictures: what videos and the simulator's buffers allow."""


def check_tasks(tasks: Sequence[str]) -> None:
    """Check that there are tasks and none of them twice.

    Raises:
        LlakeyError: if that is not so.
    """
    if not tasks or len(set(tasks)) < len(tasks):
        raise LlakeyError(
            f"Expected each task once, got {', '.join(tasks) or 'none'}; the same scenes would be collected twice, so "
            "ask for more episodes instead."
        )


@dataclass(frozen=True)
class CollectSettings:
    """What to collect; the same settings always give the same episodes.

    Attributes:
        tasks: names of tasks.
        num_episodes: for each task; their variations take turns.
        split: of the scene seeds: train, val or test.
        first_seed: index into the split of the first episode; each episode reserves ATTEMPTS seeds.
        image_size: pixels of height and width.
        fps: frames a second.
        balance: how keysteps are drawn.
        recovery: share of episodes with an unforeseen event, from which the expert recovers.
        execution_noise: share of episodes in which the hand ends beside its marks.
        events: the unforeseen events to draw from.

    Raises:
        LlakeyError: if a number makes no sense, there are not as many scene seeds, a task comes twice, or there is no
            such event.
    """

    tasks: tuple[str, ...]
    num_episodes: int
    split: str = "train"
    first_seed: int = 0
    image_size: int = schema.IMAGE_SIZE
    fps: int = 10
    balance: Balance = PAPER
    recovery: float = 0.0
    execution_noise: float = 0.0
    events: tuple[str, ...] = EVENTS

    def __post_init__(self) -> None:
        seeds = len(schema.SEED_RANGES[self.split]) if self.split in schema.SEED_RANGES else 0
        schema.scene_seed(self.split, self.first_seed)
        require_count("num_episodes", self.num_episodes, 1, (seeds - self.first_seed) // ATTEMPTS)
        require_count("image_size", self.image_size, *IMAGE_SIZES)
        require_count("fps", self.fps, 1, round(1 / TIMESTEP))
        if self.image_size % 2:
            raise LlakeyError(f"Expected an even image_size, as videos need, got {self.image_size}; correct it.")
        require_number("recovery", self.recovery, 0, 1)
        require_number("execution_noise", self.execution_noise, 0, 1)
        if self.recovery + self.execution_noise > 1:
            raise LlakeyError(
                f"Expected shares recovery and execution_noise of together at most 1, got {self.recovery} and "
                f"{self.execution_noise}; lower one."
            )
        check_tasks(self.tasks)
        if not self.events or not set(self.events) <= set(EVENTS):
            raise LlakeyError(
                f"Expected events out of {', '.join(EVENTS)}, got {', '.join(self.events) or 'none'}; pick of these."
            )

    def __len__(self) -> int:
        """Number of episodes over all tasks."""
        return len(self.tasks) * self.num_episodes

    def slot(self, index: int) -> tuple[str, int]:
        """Task of the ``index``-th episode and its number among the episodes of that task."""
        return self.tasks[index % len(self.tasks)], index // len(self.tasks)

    def seed(self, number: int, attempt: int) -> int:
        """Scene seed of an attempt at the ``number``-th episode of a task."""
        return schema.scene_seed(self.split, self.first_seed + number * ATTEMPTS + attempt)

    def disturbance(self, number: int) -> str | None:
        """What disturbs the ``number``-th episode of every task, drawn by its number alone."""
        rng = np.random.default_rng((self.first_seed, number))
        draw, event = rng.random(), str(rng.choice(self.events))
        if draw < self.recovery:
            return event
        return EXECUTION_NOISE if draw < self.recovery + self.execution_noise else None

    def resumable(self) -> dict[str, Any]:
        """What must stay the same when a run goes on or is extended."""
        kept: dict[str, Any] = {
            key: value for key, value in json.loads(json.dumps(asdict(self))).items() if key != "num_episodes"
        }
        # In the form of the first datasets' records, which knew the mode alone.
        balance = kept.pop("balance")
        kept["keystep_mode"] = balance.pop("mode")
        if self.events == EVENTS:
            del kept["events"]
        return kept | {key: value for key, value in balance.items() if value != getattr(PAPER, key)}


@dataclass(frozen=True)
class Targets:
    """Where the datasets go; at least one of them.

    Attributes:
        demonstrations: folder of the demonstrations dataset, or None.
        keysteps: folder of the keysteps dataset, or None.
        demonstrations_id: repo id of the demonstrations.
        keysteps_id: repo id of the keysteps.
    """

    demonstrations: Path | None
    keysteps: Path | None
    demonstrations_id: str = "local/demonstrations"
    keysteps_id: str = "local/keysteps"

    def named(self) -> dict[str, tuple[Path, str]]:
        """Folder and repo id by kind."""
        kinds = {
            "demonstrations": (self.demonstrations, self.demonstrations_id),
            "keysteps": (self.keysteps, self.keysteps_id),
        }
        return {kind: (root, repo_id) for kind, (root, repo_id) in kinds.items() if root is not None}
