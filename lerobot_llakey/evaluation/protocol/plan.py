"""Which episodes a table is made of, and the seed of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.sim.perturbations.registry import check_disturbance
from lerobot_llakey.sim.settings import MAX_STEPS

UNDISTURBED = ""


@dataclass(frozen=True)
class Trial:
    """One episode of one policy.

    Attributes:
        row: the policy's name in the table.
        task: name of the task.
        disturbance: the unforeseen event; empty for none.
        repeat: which repetition of the whole protocol, from 0.
        episode: which episode of the repetition, from 0.
        scene: index of the scene within the split. It fixes the scene and all else that is random in the episode.
    """

    row: str
    task: str
    disturbance: str
    repeat: int
    episode: int
    scene: int

    @property
    def key(self) -> tuple[str, str, str, int, int]:
        """What tells it from all others of the table."""
        return self.row, self.task, self.disturbance, self.repeat, self.episode

    def __str__(self) -> str:
        event = f" under {self.disturbance}" if self.disturbance else ""
        where = f"episode {self.episode} of repeat {self.repeat} of {self.task}{event} (scene {self.scene})"
        return f"{where} in the row {self.row!r}"


@dataclass(frozen=True)
class Plan:
    """The protocol: section IV-B of the paper has 25 episodes a task, 6 repeats and at most 25 steps.

    Attributes:
        tasks: names of the tasks.
        num_episodes: of each task in a repeat.
        repeats: of all episodes, on other scenes.
        max_steps: actions after which an episode ends.
        split: of the scene seeds.
        first_seed: index of the first scene within the split.
        disturbances: one part of the table each; the empty one is the undisturbed scene.
        attribution: run failed episodes again with the oracle's instructions.

    Raises:
        LlakeyError: if a count is not positive, or a split, scene or disturbance does not exist.
    """

    tasks: tuple[str, ...]
    num_episodes: int = 25
    repeats: int = 6
    max_steps: int = MAX_STEPS
    split: str = "test"
    first_seed: int = 0
    disturbances: tuple[str, ...] = (UNDISTURBED,)
    attribution: bool = True

    def __post_init__(self) -> None:
        counts = (self.num_episodes, self.repeats, self.max_steps)
        if min(counts) < 1:
            raise LlakeyError(
                f"Expected num_episodes, repeats and max_steps of 1 or more, got {counts[0]}, {counts[1]} and "
                f"{counts[2]}; correct them."
            )
        schema.scene_seed(self.split, self.first_seed)
        schema.scene_seed(self.split, self.first_seed + self.num_episodes * self.repeats - 1)
        for disturbance in self.disturbances:
            check_disturbance(disturbance)

    @property
    def episodes_a_row(self) -> int:
        """How many episodes each row takes."""
        return len(self.disturbances) * len(self.tasks) * self.repeats * self.num_episodes

    def trials(self, rows: Sequence[Row]) -> list[Trial]:
        """All episodes, row by row.

        The rows meet the same scenes, as the paper keeps its own for "one-to-one comparisons"; no two episodes of a
        row's task share one.
        """
        return [
            Trial(row.name, task, disturbance, repeat, episode, self.first_seed + repeat * self.num_episodes + episode)
            for row in rows
            for disturbance in self.disturbances
            for task in self.tasks
            for repeat in range(self.repeats)
            for episode in range(self.num_episodes)
        ]
