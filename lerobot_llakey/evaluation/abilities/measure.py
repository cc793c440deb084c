"""How well a command policy names the next instruction: the two abilities of table I in the paper.

*Sequential prediction* is measured on the samples at keyframes, where an instruction has just been completed and the
next one is to be named; *error correction* on the samples in between, where the unfinished one is to be repeated.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.utils.collate import lerobot_collate_fn
from torch.utils.data import DataLoader, Subset

from lerobot_llakey import schema
from lerobot_llakey.evaluation.abilities.remaining_distance import REMAINING_DISTANCES, remaining_distances
from lerobot_llakey.evaluation.abilities.samples import check_columns, hand_places, joint_places, samples, task_names
from lerobot_llakey.evaluation.abilities.score import Score, macro
from lerobot_llakey.evaluation.abilities.situation import SITUATIONS, situations
from lerobot_llakey.grammar import Grammar, of_features
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.prepared import Preprocessor, prepared

SEQUENTIAL_PREDICTION = "sequential_prediction"
ERROR_CORRECTION = "error_correction"
ABILITIES = (SEQUENTIAL_PREDICTION, ERROR_CORRECTION)
ALL_SAMPLES = "all"
AVERAGE = "average"
AFTER_EVENTS = "after_events"
BY_REMAINING_DISTANCE = "error_correction_by_way_left"
BY_SITUATION = "by_situation"


class Commander(Protocol):
    """What is measured: anything that names instructions for a batch, such as ``LlakeyCommandPolicy``."""

    def next_instructions(self, batch: dict[str, Any]) -> list[str]: ...


@dataclass
class Measured:
    """The answers of a policy, counted.

    Attributes:
        tasks: by ability and task.
        events: by ability and disturbance, the answers to frames in which it can be seen; empty where the dataset does
            not tell or nothing was disturbed.
        left: the answers to frames in between, by how far the hand still had to go.
        situations: all answers, by what the robot was doing.
        grammar: of the instructions.
    """

    tasks: dict[str, dict[str, Score]] = field(default_factory=lambda: {name: {} for name in ABILITIES})
    events: dict[str, dict[str, Score]] = field(default_factory=lambda: {name: {} for name in ABILITIES})
    left: dict[str, Score] = field(default_factory=dict)
    situations: dict[str, Score] = field(default_factory=dict)
    grammar: Grammar = BASIC_GRAMMAR

    def add(
        self, ability: str, task: str, event: str, expected: str, answer: str, left: str = "", situation: str = ""
    ) -> None:
        """Count one answer under its task and, where there is one, under the event before it.

        Where they are known it is counted under the situation as well and, between keyframes, under the way left.
        """
        self.tasks[ability].setdefault(task, Score()).add(expected, answer, self.grammar)
        if event:
            self.events[ability].setdefault(event, Score()).add(expected, answer, self.grammar)
        if left and ability == ERROR_CORRECTION:
            self.left.setdefault(left, Score()).add(expected, answer, self.grammar)
        if situation:
            self.situations.setdefault(situation, Score()).add(expected, answer, self.grammar)

    def total(self, ability: str) -> Score:
        """All answers of an ability."""
        return sum(self.tasks[ability].values(), Score())

    def summary(self) -> dict[str, Any]:
        """For each ability the figures of each task, of ``"all"`` samples and of the ``"average"`` over tasks.

        Under ``"after_events"`` the same for the frames after each disturbance, under
        ``"error_correction_by_way_left"`` for frames in between, by how far the hand still had to go, and under
        ``"by_situation"`` for all frames, by what the robot was doing.
        """
        result: dict[str, Any] = {}
        for ability, scores in self.tasks.items():
            named = {name: scores[name].summary() for name in sorted(scores)}
            whole = {ALL_SAMPLES: self.total(ability).summary(), AVERAGE: macro(list(scores.values()))}
            result[ability] = named | whole
        result[AFTER_EVENTS] = {
            ability: {name: scores[name].summary() for name in sorted(scores)}
            for ability, scores in self.events.items()
        }
        result[BY_REMAINING_DISTANCE] = {
            name: self.left[name].summary() for name in REMAINING_DISTANCES if name in self.left
        }
        result[BY_SITUATION] = {name: self.situations[name].summary() for name in SITUATIONS if name in self.situations}
        return result


def measure(
    policy: Commander,
    preprocessor: Preprocessor,
    dataset: LeRobotDataset,
    batch_size: int = 32,
    max_samples: int | None = None,
    num_workers: int = 0,
) -> Measured:
    """Measure both abilities of a command policy on a dataset that it was not trained on.

    Args:
        policy: the command policy.
        preprocessor: its preprocessor.
        dataset: keysteps or demonstrations in the data contract.
        batch_size: samples a decision.
        max_samples: how many samples to look at, spread evenly over the dataset; None for all.
        num_workers: processes that load the data.

    Raises:
        LlakeyError: if the dataset has no instructions or does not tell keyframes apart.
    """
    check_columns(dataset)
    chosen = samples(dataset, max_samples)
    names = task_names(dataset)
    hand, joints = hand_places(dataset.features), joint_places(dataset.features)
    tasks = iter([names[index] for index in chosen])
    measured = Measured(grammar=of_features(dataset.features, schema.INSTRUCTION))
    loader = DataLoader(
        Subset(dataset, chosen), batch_size=batch_size, num_workers=num_workers, collate_fn=lerobot_collate_fn
    )
    for batch in loader:
        expected = list(batch[schema.INSTRUCTION])
        events = batch.get(schema.EPISODE_EVENT, [""] * len(expected))
        at_keyframe = batch[schema.IS_KEYFRAME].reshape(-1).tolist()
        answers = policy.next_instructions(prepared(batch, preprocessor))
        counted = zip(
            at_keyframe,
            events,
            expected,
            answers,
            remaining_distances(batch, hand),
            situations(batch, joints),
            strict=True,
        )
        for keyframe, *told in counted:
            measured.add(SEQUENTIAL_PREDICTION if keyframe else ERROR_CORRECTION, next(tasks), *told)
    return measured
