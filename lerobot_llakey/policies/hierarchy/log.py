"""Writes down the steps of each episode as JSON lines."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from lerobot_llakey.policies.hierarchy.record import Step


class EpisodeLog:
    """The steps of the running episodes, kept in memory and, if wanted, in one file an episode.

    A file is named after its episode's key and the policy's seed, so the same episode run again writes the same file
    anew. Lines are written as they come. In a batch, the steps of a row go on until the last row is done, because the
    policy is not told which rows are.

    Args:
        folder: where the files go; None keeps the steps in memory only.

    Attributes:
        steps: those of each row since the last :meth:`begin`.
    """

    def __init__(self, folder: str | Path | None = None) -> None:
        self.folder = None if folder is None else Path(folder)
        self.steps: list[list[Step]] = []
        self._files: list[Path] = []

    def begin(self, keys: Sequence[int], seed: int) -> None:
        """Start the episodes of a batch.

        Args:
            keys: one for each row; rows with the same key get files of their own.
            seed: of the policy.
        """
        self.steps = [[] for _ in keys]
        self._files = []
        if self.folder is None:
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        for row, key in enumerate(keys):
            twin = list(keys[:row]).count(key)
            file = self.folder / f"{key:016x}_seed{seed}{f'_{twin}' if twin else ''}.jsonl"
            file.write_text("", encoding="utf-8")
            self._files.append(file)

    def add(self, steps: Sequence[Step]) -> None:
        """Take one step of each row."""
        for step in steps:
            self.steps[step.row].append(step)
            if self._files:
                with self._files[step.row].open("a", encoding="utf-8") as file:
                    file.write(json.dumps(step.as_json()) + "\n")
