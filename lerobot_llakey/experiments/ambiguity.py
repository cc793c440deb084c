"""The stages of the ambiguity study (figure 1): do policies follow the verbs of the skill instruction?"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.datasets.collect import collect
from lerobot_llakey.datasets.plan import CollectSettings, Targets
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.records import EPISODES, Records
from lerobot_llakey.evaluation.protocol.runner import VIDEOS, make_missing_films, run_missing
from lerobot_llakey.experiments.ambiguity_report import ambiguity_page, plot_ambiguity, summarise
from lerobot_llakey.experiments.arms import BASELINE, LLAKEY, Arm, make_arms, make_plan
from lerobot_llakey.experiments.rates import Rates
from lerobot_llakey.experiments.rewording import reworded_copy
from lerobot_llakey.experiments.settings import AmbiguitySettings, TrainingSettings
from lerobot_llakey.experiments.stages import Stage
from lerobot_llakey.experiments.training import Training
from lerobot_llakey.experiments.wordings import TASK_NAME, TRAININGS
from lerobot_llakey.files import alone_in, write_whole
from lerobot_llakey.sim.settings import MAX_STEPS

PAGE, PLOT = "ambiguity.md", "ambiguity.png"
_PREFIX = "ambiguity"


@dataclass(frozen=True)
class Ambiguity:
    """The study.

    Args:
        settings: how much.
        folder: of everything.
        device: PyTorch's, of training.
        launcher: words in place of python for a training.
        max_steps: actions after which an episode ends.
        num_workers: processes; one for each CPU core where 0.
        action: an action policy's checkpoint that knows put_bulb; one is trained where None.
        after: the stages that the action policy comes from.
    """

    settings: AmbiguitySettings
    folder: Path
    device: str = "cpu"
    launcher: str = ""
    max_steps: int = MAX_STEPS
    num_workers: int = 0
    action: Path | None = None
    after: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.action is None and not self.settings.action.recipe:
            raise LlakeyError("Expected an action policy or a recipe for one, got neither; set action.recipe.")

    @property
    def trainings(self) -> dict[str, Training]:
        """By the name of the stage."""
        found: dict[str, Training] = {}
        if self.settings.action.recipe:
            found[f"{_PREFIX}_action"] = self._training("action", "one", self.settings.action)
        for training in TRAININGS:
            for kind, settings in (("command", self.settings.command), ("baseline", self.settings.baseline)):
                found[f"{_PREFIX}_{kind}_{training}"] = self._training(f"{kind}_{training}", training, settings)
        return found

    @property
    def arms(self) -> list[Arm]:
        """All arms."""
        trainings = self.trainings
        policies = {
            (method, training): trainings[f"{_PREFIX}_{kind}_{training}"].checkpoint
            for method, kind in ((BASELINE, "baseline"), (LLAKEY, "command"))
            for training in TRAININGS
        }
        own = trainings.get(f"{_PREFIX}_action")
        return make_arms(self.settings.tests, policies, own.checkpoint if own else self.action)

    def stages(self) -> list[Stage]:
        """The stages, in order."""
        data = Stage(
            f"{_PREFIX}_collect",
            f"{self.settings.num_demos} demonstrations of {TASK_NAME}, as keysteps",
            {"num_demos": self.settings.num_demos},
            produces=(self._demos,),
            work=self._collect,
            seconds=lambda rates: self.settings.num_demos * rates.keystep_episode / rates.cores,
        )
        words = Stage(
            f"{_PREFIX}_wordings",
            "the same in one wording and in two",
            {},
            (data.name,),
            tuple(self._worded(training) for training in TRAININGS),
            self._reword,
        )
        trainings = [
            training_stage(name, f"{training.steps} steps for the study of verbs", training, (words.name,))
            for name, training in self.trainings.items()
        ]
        plan = self._plan()
        episodes = len(self.arms) * plan.episodes_a_row
        study = Stage(
            _PREFIX,
            f"figure 1: {episodes} episodes in {len(self.arms)} arms",
            {"plan": vars(plan), "tests": self.settings.tests, "num_videos": self.settings.num_videos},
            (*(stage.name for stage in trainings), *self.after),
            tuple(self.folder / name for name in (EPISODES, VIDEOS, PAGE, PLOT, "results.json")),
            self._study,
            seconds=lambda rates: episodes * self.max_steps * rates.action / rates.cores,
        )
        return [data, words, *trainings, study]

    @property
    def _demos(self) -> Path:
        return self.folder / "keysteps"

    def _worded(self, training: str) -> Path:
        return self.folder / f"keysteps_{training}"

    def _training(self, name: str, wording: str, settings: TrainingSettings) -> Training:
        return Training(
            f"{_PREFIX}_{name}",
            settings,
            f"local/{TASK_NAME}_{wording}",
            self._worded(wording),
            self.folder / "policies" / name,
            self.folder / "logs" / f"{name}.log",
            self.device,
            self.launcher,
        )

    def _plan(self) -> Plan:
        return make_plan(self.settings.num_episodes, self.settings.repeats, self.max_steps)

    def _collect(self) -> None:
        targets = Targets(None, self._demos, keysteps_id=f"local/{TASK_NAME}")
        collect(CollectSettings((TASK_NAME,), self.settings.num_demos), targets, self.num_workers)

    def _reword(self) -> None:
        for training in TRAININGS:
            reworded_copy(self._demos, self._worded(training), training)

    def _study(self) -> None:
        plan, arms = self._plan(), self.arms
        with alone_in(self.folder):
            rows, records = [arm.row for arm in arms], Records(self.folder / EPISODES)
            run_missing(plan, rows, records, self.num_workers)
            summary = summarise(plan, arms, records)
            plot_ambiguity(self.folder / PLOT, summary)
            write_whole(self.folder / "results.json", json.dumps({"plan": vars(plan), "arms": summary}, indent=2))
            write_whole(self.folder / PAGE, ambiguity_page(plan, summary))
            videos = self.folder / VIDEOS
            make_missing_films(plan, rows, records, videos, self.settings.num_videos, False, self.num_workers)


def training_stage(name: str, title: str, training: Training, needs: tuple[str, ...]) -> Stage:
    """A training as a stage."""

    def seconds(rates: Rates) -> float:
        return rates.start + training.steps * rates.step.get(name, 0.0)

    return Stage(name, title, training.described(), needs, (training.output_dir,), training=training, seconds=seconds)
