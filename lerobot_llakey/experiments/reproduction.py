"""The whole paper as stages: collect, keysteps, train, compose, abilities, table I, figure 6, figure 1, one report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey.evaluation.abilities.files import write_abilities
from lerobot_llakey.evaluation.abilities.measure import measure
from lerobot_llakey.evaluation.experiment import Output, report_rollback, report_table, run_experiment
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.experiments.ambiguity import Ambiguity, training_stage
from lerobot_llakey.experiments.data import Data
from lerobot_llakey.experiments.policies import ACTION, COMMAND, Policies
from lerobot_llakey.experiments.rates import Rates
from lerobot_llakey.experiments.settings import AmbiguitySettings, DataSettings, RollbackSettings, TableSettings
from lerobot_llakey.experiments.settings import TrainSettings as Train
from lerobot_llakey.experiments.stages import Stage
from lerobot_llakey.experiments.training import Training
from lerobot_llakey.experiments.wordings import TASK_NAME
from lerobot_llakey.policies.hierarchy.compose import compose
from lerobot_llakey.rollout.actors import Agent
from lerobot_llakey.sim.settings import MAX_STEPS
from lerobot_llakey.sim.tasks import parse_tasks

_SAMPLES_AN_EPISODE = 25


@dataclass
class Scale:
    """How much of everything; the fields of a scale's YAML file.

    Attributes:
        scale: its name.
        task: task names separated by commas, or all.
        max_steps: actions after which an episode ends.
        split: of the scene seeds on which policies are evaluated.
        data: what is collected.
        train: what is trained.
        table: table I.
        rollback: figure 6.
        ambiguity: figure 1.
        num_workers: processes that collect and evaluate; one for each CPU core where 0.
    """

    scale: str = "paper"
    task: str = "all"
    max_steps: int = MAX_STEPS
    split: str = "test"
    data: DataSettings = field(default_factory=DataSettings)
    train: Train = field(default_factory=Train)
    table: TableSettings = field(default_factory=TableSettings)
    rollback: RollbackSettings = field(default_factory=RollbackSettings)
    ambiguity: AmbiguitySettings = field(default_factory=AmbiguitySettings)
    num_workers: int = 0


@dataclass(frozen=True)
class Reproduction:
    """A scale in a folder.

    Args:
        scale: how much.
        folder: of everything.
        device: PyTorch's, of training.
    """

    scale: Scale
    folder: Path
    device: str = "cpu"

    @property
    def tasks(self) -> tuple[str, ...]:
        """Names of the tasks."""
        return tuple(parse_tasks(self.scale.task))

    @property
    def data(self) -> Data:
        """The datasets."""
        return Data(self.scale.data, self.tasks, self.folder / "data", self.scale.num_workers)

    @property
    def policies(self) -> Policies:
        """What is trained."""
        return Policies(self.scale.train, self.data, self.folder, self.device)

    @property
    def ambiguity(self) -> Ambiguity | None:
        """Figure 1, where it is asked for."""
        settings, action = self.scale.ambiguity, None
        if not settings.num_demos:
            return None
        if not settings.action.recipe and TASK_NAME in self.tasks:
            action = self.policies.trainings[ACTION].checkpoint
        return Ambiguity(
            settings,
            self.folder / "ambiguity",
            self.device,
            self.scale.train.launcher,
            self.scale.max_steps,
            self.scale.num_workers,
            action,
            (ACTION,) if action else (),
        )

    @property
    def trainings(self) -> dict[str, Training]:
        """All, by the name of the stage."""
        ambiguity = self.ambiguity
        return self.policies.trainings | (ambiguity.trainings if ambiguity else {})

    def plan(self, num_episodes: int, repeats: int, attribution: bool, events: tuple[str, ...] = ("",)) -> Plan:
        """The protocol of a table."""
        scale = self.scale
        return Plan(
            self.tasks,
            num_episodes,
            repeats,
            scale.max_steps,
            scale.split,
            disturbances=events,
            attribution=attribution,
        )

    def stages(self) -> list[Stage]:
        """The stages, in order."""
        ambiguity = self.ambiguity
        trainings = [
            training_stage(name, _training_title(training), training, ("keysteps",))
            for name, training in self.policies.trainings.items()
        ]
        names = tuple(stage.name for stage in trainings)
        return [
            self._collect(),
            self._keysteps(),
            *trainings,
            self._composed(),
            self._abilities(tuple(name for name in names if name != ACTION)),
            self._table((*names, "compose")),
            self._rollback((*names, "compose")),
            *(ambiguity.stages() if ambiguity else []),
        ]

    def _collect(self) -> Stage:
        data, settings = self.data, self.scale.data

        def seconds(rates: Rates) -> float:
            each = rates.demonstration if settings.demonstrations else rates.keystep_episode
            unseen = len(data.val.settings) * rates.keystep_episode
            return (data.episodes * each + unseen) / rates.cores

        title = f"{data.episodes} demonstrations, {len(data.val.settings)} unseen episodes"
        described = {"task": self.scale.task, **asdict(settings)}
        return Stage("collect", title, described, (), (data.folder,), data.collect, seconds=seconds)

    def _keysteps(self) -> Stage:
        data = self.data
        drawn = data.episodes if self.scale.data.demonstrations else 0
        return Stage(
            "keysteps",
            "the training samples of the paper",
            {},
            ("collect",),
            data.drawn_roots,
            data.draw_keysteps,
            seconds=lambda rates: drawn * rates.keysteps,
        )

    def _composed(self) -> Stage:
        title, produces = "one checkpoint of both levels", (self.policies.llakey,)
        return Stage("compose", title, {}, (ACTION, COMMAND), produces, self._compose)

    def _compose(self) -> None:
        trainings = self.policies.trainings
        compose(trainings[COMMAND].checkpoint, trainings[ACTION].checkpoint, self.policies.llakey)

    def _abilities(self, needs: tuple[str, ...]) -> Stage:
        folder, commanders = self.folder / "abilities", self.policies.commanders()
        samples = len(self.data.val.settings) * _SAMPLES_AN_EPISODE

        def work() -> None:
            dataset = LeRobotDataset("local/val", root=self.data.val_root)
            for name, path in commanders.items():
                agent = Agent.load(path)
                write_abilities(measure(agent.policy, agent.preprocessor, dataset), folder / name.replace(" ", "_"))

        return Stage(
            "abilities",
            f"both abilities of {len(commanders)} command policies",
            {},
            needs,
            (folder,),
            work,
            seconds=lambda rates: len(commanders) * samples * rates.answer,
        )

    def _table(self, needs: tuple[str, ...]) -> Stage:
        settings = self.scale.table
        plan = self.plan(settings.num_episodes, settings.repeats, settings.attribution)
        rows, output = self.policies.rows(settings), self._output("table", settings.num_videos)
        return self._experiment("table", "table I", plan, rows, output, needs)

    def _rollback(self, needs: tuple[str, ...]) -> Stage:
        settings = self.scale.rollback
        events = tuple(event.strip() for event in settings.disturbance.split(",") if event.strip())
        plan = self.plan(settings.num_episodes, 1, True, events)
        output = self._output("rollback", settings.num_videos)
        return self._experiment("rollback", "figure 6", plan, self.policies.rollback_rows(), output, needs)

    def _output(self, name: str, num_videos: int) -> Output:
        return Output(self.folder / name, num_videos, num_workers=self.scale.num_workers)

    def _experiment(
        self, name: str, title: str, plan: Plan, rows: Sequence[Row], output: Output, needs: tuple[str, ...]
    ) -> Stage:
        report = report_table if name == "table" else report_rollback
        episodes = len(rows) * plan.episodes_a_row

        def work() -> None:
            run_experiment(plan, rows, output, report)

        def seconds(rates: Rates) -> float:
            # As if every episode went on to its last action and was run again for the attribution: policies may fail.
            return episodes * plan.max_steps * rates.action * (2 if plan.attribution else 1) / rates.cores

        return Stage(
            name,
            f"{title}: {episodes} episodes in {len(rows)} rows",
            {"plan": asdict(plan), "rows": [row.described() for row in rows], "num_videos": output.num_videos},
            needs,
            (output.folder,),
            work,
            seconds=seconds,
        )


def _training_title(training: Training) -> str:
    return f"{training.steps} steps of {training.batch_size} samples"
