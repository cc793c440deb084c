"""How well a command policy names the next instruction: the two abilities of table I in the paper.

*Sequential prediction* is measured on the samples at keyframes, where an instruction has just been completed and the
next one is to be named; *error correction* on the samples in between, where the unfinished one is to be repeated.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import torch
from torch.utils.data import DataLoader, Dataset, Subset

from lerobot_llakey import instructions, schema

SEQUENTIAL_PREDICTION = "sequential_prediction"
ERROR_CORRECTION = "error_correction"
ALL_TASKS = "all"


class Commander(Protocol):
    """What is measured: anything that names instructions for a batch, such as ``LlakeyCommandPolicy``."""

    def next_instructions(self, batch: dict[str, Any]) -> list[str]: ...


@dataclass
class Score:
    """Counts of right answers.

    Attributes:
        samples: answers looked at.
        exact: answers that are the expected instruction, wordings of the same template counting as one.
        verb: answers with the expected template, whatever their objects.
        objects: answers with the expected noun phrases, whatever their template.
        confusions: how often which wrong answer was given, by (expected, answer).
    """

    samples: int = 0
    exact: int = 0
    verb: int = 0
    objects: int = 0
    confusions: dict[tuple[str, str], int] = field(default_factory=lambda: defaultdict(int))

    def add(self, expected: str, answer: str) -> None:
        """Count one answer; an answer outside the grammar is right only if it is the expected text itself."""
        self.samples += 1
        if answer == expected:
            self.exact, self.verb, self.objects = self.exact + 1, self.verb + 1, self.objects + 1
            return
        wanted, given = _parsed(expected), _parsed(answer)
        verb = wanted is not None and given is not None and wanted.template == given.template
        objects = wanted is not None and given is not None and _objects(wanted) == _objects(given)
        exact = verb and wanted is not None and given is not None and wanted.arguments == given.arguments
        self.verb, self.objects, self.exact = self.verb + verb, self.objects + objects, self.exact + exact
        if not exact:
            self.confusions[expected, answer] += 1

    def summary(self, confusions: int = 5) -> dict[str, Any]:
        """Shares in 0..1, the number of samples, and the commonest wrong answers."""
        worst = sorted(self.confusions.items(), key=lambda item: (-item[1], item[0]))[:confusions]
        return {
            "samples": self.samples,
            **{name: getattr(self, name) / max(1, self.samples) for name in ("exact", "verb", "objects")},
            "confusions": [{"expected": pair[0], "answer": pair[1], "count": count} for pair, count in worst],
        }


def abilities(
    policy: Commander,
    preprocessor: Callable[[dict[str, Any]], dict[str, Any]],
    dataset: Dataset[Any],
    batch_size: int = 32,
    max_samples: int | None = None,
    group: Callable[[str], str] = str,
    num_workers: int = 0,
) -> dict[str, dict[str, dict[str, Any]]]:
    """Measure both abilities of a command policy on a keysteps dataset that it was not trained on.

    Args:
        policy: the command policy.
        preprocessor: its preprocessor.
        dataset: a LeRobotDataset in the data contract.
        batch_size: samples a decision.
        max_samples: how many samples to look at, spread evenly over the dataset; None for all.
        group: maps a skill instruction to the name under which it is counted, to join a task's variations.
        num_workers: processes that load the data.

    Returns:
        For each ability, for each group and for ``"all"``, what :meth:`Score.summary` tells.

    Raises:
        ValueError: if the dataset has no instructions or does not tell keyframes apart.
    """
    count = len(dataset)  # type: ignore[arg-type]
    if max_samples is not None and max_samples < count:
        dataset = Subset(dataset, torch.linspace(0, count - 1, max_samples).long().tolist())
    scores: dict[str, dict[str, Score]] = {
        ability: defaultdict(Score) for ability in (SEQUENTIAL_PREDICTION, ERROR_CORRECTION)
    }
    for batch in DataLoader(dataset, batch_size=batch_size, num_workers=num_workers):
        _check(batch)
        at_keyframe = batch[schema.IS_KEYFRAME].reshape(-1).tolist()
        expected, tasks = list(batch[schema.INSTRUCTION]), list(batch[schema.TASK])
        answers = policy.next_instructions(preprocessor(batch))
        for keyframe, task, wanted, answer in zip(at_keyframe, tasks, expected, answers, strict=True):
            ability = scores[SEQUENTIAL_PREDICTION if keyframe else ERROR_CORRECTION]
            for name in (group(task), ALL_TASKS):
                ability[name].add(wanted, answer)
    return {
        ability: {name: score.summary() for name, score in sorted(by_group.items())}
        for ability, by_group in scores.items()
    }


def _check(batch: Mapping[str, Any]) -> None:
    missing = [key for key in (schema.IS_KEYFRAME, schema.INSTRUCTION) if key not in batch]
    if missing:
        raise ValueError(f"Expected the columns {missing} in the dataset, got none; make one with `llakey keysteps`.")


def _parsed(text: str) -> instructions.Instruction | None:
    try:
        return instructions.parse(text)
    except ValueError:
        return None


def _objects(instruction: instructions.Instruction) -> tuple[str, ...]:
    """The noun phrases, without the pose relative to one."""
    slots = instructions.TEMPLATES[instruction.template].slots
    return tuple(text for slot, text in zip(slots, instruction.arguments, strict=True) if slot != "pose")
