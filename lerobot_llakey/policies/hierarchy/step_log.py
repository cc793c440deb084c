"""What happened in each step of the loop, kept in memory and written down as JSON lines."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Step:
    """One step of one row.

    Attributes:
        row: of the batch.
        index: number of the step since the last reset, from 0.
        task: the skill instruction, "" if the batch had none.
        said: the words of the commander, as given.
        instruction: what was carried out: the words in their canonical form, or what took their place.
        source: who said it: "policy", "oracle", "task", "list" or "person"; "fallback" where nothing valid was said
            yet, "previous" where the last valid instruction took the place of words outside the grammar.
        likelihood: of the words, in 0..1; None where that has no meaning or others took their place.
        unparsable: whether the words were outside the grammar in the end.
        repeats: how often the instruction was given again without a break, as the stall rule counted before the step.
        random_move: whether a random move took the proposed pose's place.
        moved: whether the step before moved the hand or the gripper; None at the first step.
        state: (8,) the hand before the step: position in metres, quaternion xyzw, gripper opening.
        proposed: (9,) action as the action policy gave it: metres, xyzw, gripper, collision flag.
        sent: (9,) action as it was sent.
    """

    row: int
    index: int
    task: str
    said: str
    instruction: str
    source: str
    likelihood: float | None
    unparsable: bool
    repeats: int
    random_move: bool
    moved: bool | None
    state: tuple[float, ...]
    proposed: tuple[float, ...]
    sent: tuple[float, ...]

    def as_json(self) -> dict[str, Any]:
        """The step as plain values for ``json.dumps``, its poses to six digits."""
        plain = asdict(self)
        return {
            key: [round(x, 6) for x in value] if isinstance(value, tuple) else value for key, value in plain.items()
        }


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
