"""What to collect with a policy: settings that fix every episode beforehand."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.bounds import require_count, require_number
from lerobot_llakey.datasets.plan import IMAGE_SIZES, check_tasks
from lerobot_llakey.sim.perturbations.registry import check_disturbance


@dataclass(frozen=True)
class DaggerSettings:
    """What to collect; the same settings and weights give the same episodes.

    Attributes:
        policy_path: checkpoint of a hierarchical policy: who acts.
        tasks: names of tasks.
        num_episodes: of each task; in every other one the expert instructs and the action policy acts.
        split: of the scene seeds: train, val or test.
        first_seed: index into the split of the first episode.
        image_size: pixels of height and width.
        max_steps: actions after which an episode ends.
        expert_share: share of the actions that the expert carries out itself, so that later states are met as well.
        disturbance: what disturbs every episode, out of
            :data:`~lerobot_llakey.sim.perturbations.registry.DISTURBANCES`; nothing where empty.

    Raises:
        LlakeyError: if a number is out of range, or the split or the disturbance is unknown.
    """

    policy_path: str
    tasks: tuple[str, ...]
    num_episodes: int
    split: str = "train"
    first_seed: int = 0
    image_size: int = schema.IMAGE_SIZE
    max_steps: int = 15
    expert_share: float = 0.2
    disturbance: str = ""

    def __post_init__(self) -> None:
        schema.scene_seed(self.split, self.first_seed)
        require_count("num_episodes", self.num_episodes, 1, len(schema.SEED_RANGES[self.split]) - self.first_seed)
        require_count("image_size", self.image_size, *IMAGE_SIZES)
        require_count("max_steps", self.max_steps, 1)
        require_number("expert_share", self.expert_share, 0, 1)
        check_tasks(self.tasks)
        check_disturbance(self.disturbance)

    def __len__(self) -> int:
        """Number of episodes over all tasks."""
        return len(self.tasks) * self.num_episodes

    def parts(self, size: int) -> Iterator[tuple[str, int, int]]:
        """Task, first and end number of the episodes of each part, at most ``size`` long."""
        for task in self.tasks:
            for start in range(0, self.num_episodes, size):
                yield task, start, min(start + size, self.num_episodes)

    def resumable(self) -> dict[str, Any]:
        """What must stay the same when a run goes on."""
        kept: dict[str, Any] = json.loads(json.dumps(asdict(self)))
        # As in the records of datasets made before there was this setting.
        if not self.disturbance:
            del kept["disturbance"]
        return kept
