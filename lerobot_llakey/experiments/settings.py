"""What a scale of ``llakey reproduce`` says: how much is collected, trained and evaluated. A scale is a YAML file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import lerobot_llakey
from lerobot_llakey.bounds import require_count, require_number
from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.experiments.wordings import TESTS

_FOLDER = "configs"


@dataclass
class TrainingSettings:
    """One training run of LeRobot; whatever is not given is the recipe's.

    Attributes:
        recipe: YAML file for ``lerobot-train --config_path``; without one this policy is left out.
        steps: of training; 0 as in the recipe.
        batch_size: samples a step; 0 as in the recipe.
        num_workers: processes that load samples; -1 as in the recipe.
        save_freq: steps between checkpoints, from which a killed run goes on; 0 as in the recipe.
        arguments: others of ``lerobot-train``, each as on a command line.
    """

    recipe: str = ""
    steps: int = 0
    batch_size: int = 0
    num_workers: int = -1
    save_freq: int = 0
    arguments: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        for name in ("steps", "batch_size", "save_freq"):
            require_count(f"{name} of a training", getattr(self, name))
        require_count("num_workers of a training", self.num_workers, -1)


@dataclass
class DataSettings:
    """What is collected of each task (section IV-B of the paper).

    Attributes:
        action_episodes: demonstrations for the action policy and the baseline.
        command_episodes: for the command policy, of tasks with one sequence of actions; the action policy's are among
            them.
        multi_sequence_episodes: for the command policy, of tasks with several.
        val_episodes: of unseen scenes, for the command policy's abilities.
        recovery: share of episodes with an unforeseen event, from which the expert recovers; the paper has none.
        execution_noise: share of episodes in which the hand ends beside its marks.
        demonstrations: write every frame as video first, and draw keysteps from that; else keysteps at once.
        keystep_mode: how keysteps at keyframes count more: thin, repeat or weight.
    """

    action_episodes: int = 100
    command_episodes: int = 100
    multi_sequence_episodes: int = 200
    val_episodes: int = 25
    recovery: float = 0.0
    execution_noise: float = 0.0
    demonstrations: bool = True
    keystep_mode: str = "thin"

    def __post_init__(self) -> None:
        counts = (self.action_episodes, self.command_episodes, self.multi_sequence_episodes)
        if min(self.action_episodes, self.val_episodes) < 1 or max(self.action_episodes, counts[1]) > min(counts[1:]):
            raise LlakeyError(
                "Expected 1 <= action_episodes <= command_episodes <= multi_sequence_episodes and val_episodes >= 1, "
                f"got {counts} and {self.val_episodes}; correct them."
            )
        for name in ("recovery", "execution_noise"):
            require_number(f"--data.{name}", getattr(self, name), 0.0, 1.0)


@dataclass
class TrainSettings:
    """What is trained, and how.

    Attributes:
        action: the action policy, told the instruction.
        command: the command policy with its three views.
        baseline: the action policy told the skill instruction and the timestep instead.
        one_view: the command policy with one view.
        direct: a policy that predicts the action without instructions in between.
        side_by_side: trainings at the same time.
        launcher: what starts a training in place of python, such as ``accelerate launch --num_processes=4``.
    """

    action: TrainingSettings = field(default_factory=TrainingSettings)
    command: TrainingSettings = field(default_factory=TrainingSettings)
    baseline: TrainingSettings = field(default_factory=TrainingSettings)
    one_view: TrainingSettings = field(default_factory=TrainingSettings)
    direct: TrainingSettings = field(default_factory=TrainingSettings)
    side_by_side: int = 1
    launcher: str = ""

    def __post_init__(self) -> None:
        require_count("--train.side_by_side", self.side_by_side, 1, 64)


@dataclass
class TableSettings:
    """Table I.

    Attributes:
        num_episodes: of each task in a repeat.
        repeats: of all episodes.
        attribution: tell which level failed.
        num_videos: successes and failures of each row and task.
        chat_url: address of a chat server, whose model is a row too; none where empty.
        chat_model: its model.
    """

    num_episodes: int = 25
    repeats: int = 6
    attribution: bool = True
    num_videos: int = 2
    chat_url: str = ""
    chat_model: str = ""

    def __post_init__(self) -> None:
        require_count("--table.num_episodes", self.num_episodes, 1, 1_000_000)
        require_count("--table.repeats", self.repeats, 1, 1000)
        require_count("--table.num_videos", self.num_videos)


@dataclass
class RollbackSettings:
    """Figure 6.

    Attributes:
        num_episodes: of each task and event.
        disturbance: the events, separated by commas.
        num_videos: recoveries and failures of each row, task and event.
    """

    num_episodes: int = 25
    disturbance: str = "drop,block,shift,empty_grasp"
    num_videos: int = 1

    def __post_init__(self) -> None:
        require_count("--rollback.num_episodes", self.num_episodes, 1, 1_000_000)
        require_count("--rollback.num_videos", self.num_videos)


@dataclass
class AmbiguitySettings:
    """Figure 1.

    Attributes:
        num_demos: demonstrations of ``put_bulb``; none leaves the study out.
        num_episodes: of each arm in a repeat.
        repeats: of all episodes.
        num_videos: successes and failures of each arm.
        action: trained on put_bulb; without a recipe the action policy of the table, which must know the task.
        command: trained once with one wording and once with two.
        baseline: likewise.
        tests: wordings tested, out of as_trained, swapped, replaced and removed.
    """

    num_demos: int = 200
    num_episodes: int = 25
    repeats: int = 6
    num_videos: int = 1
    action: TrainingSettings = field(default_factory=TrainingSettings)
    command: TrainingSettings = field(default_factory=TrainingSettings)
    baseline: TrainingSettings = field(default_factory=TrainingSettings)
    tests: list[str] = field(default_factory=lambda: list(TESTS))

    def __post_init__(self) -> None:
        require_count("num_episodes of the ambiguity study", self.num_episodes, 1, 1_000_000)
        require_count("num_demos of the ambiguity study", self.num_demos, 0, 1_000_000)
        require_count("repeats of the ambiguity study", self.repeats, 1, 1000)
        require_count("num_videos of the ambiguity study", self.num_videos)
        unknown = [test for test in self.tests if test not in TESTS]
        if unknown or not self.tests:
            raise LlakeyError(f"Expected tests out of {', '.join(TESTS)}, got {self.tests}; correct them.")


def find_config(name: str, folders: Sequence[Path] | None = None) -> Path:
    """A file of ``configs/``: as given, or beside the package's sources, wherever the command is run.

    Raises:
        MissingFileError: if there is none.
    """
    package = Path(lerobot_llakey.__file__).parent
    given = Path(name)
    for folder in (Path(), package.parent, package) if folders is None else folders:
        for path in (folder / given, folder / _FOLDER / given.name):
            if path.is_file():
                return path
    raise MissingFileError(f"Expected a YAML file, got {name}, where none was found; give its path.")
