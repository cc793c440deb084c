"""The datasets of the paper: what each policy is trained on, and what the abilities are measured on."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey.datasets.balance import Balance, sampling_mode
from lerobot_llakey.datasets.collect import collect, quieten
from lerobot_llakey.datasets.keysteps import convert
from lerobot_llakey.datasets.merge import merge
from lerobot_llakey.datasets.plan import ATTEMPTS, CollectSettings, Targets
from lerobot_llakey.experiments.settings import DataSettings
from lerobot_llakey.sim.tasks import task_classes

BASE, VAL = "base", "val"


@dataclass(frozen=True)
class Collection:
    """Episodes that are collected together.

    Attributes:
        name: of the folder.
        settings: of the collection.
    """

    name: str
    settings: CollectSettings


@dataclass(frozen=True)
class Data:
    """All datasets of a reproduction.

    The collections: what all policies share, and what the command policy has beyond that; scenes never recur.

    Args:
        settings: how much.
        tasks: names of the tasks.
        folder: of the datasets.
        num_workers: processes; one for each CPU core where 0.
    """

    settings: DataSettings
    tasks: tuple[str, ...]
    folder: Path
    num_workers: int = 0

    @property
    def action_root(self) -> Path:
        """Keysteps for the action policy and the baseline."""
        return self._keysteps(BASE)

    @property
    def command_root(self) -> Path:
        """Keysteps for the command policy."""
        return self._keysteps("all") if len(self.training) > 1 else self._keysteps(BASE)

    @property
    def drawn_roots(self) -> tuple[Path, ...]:
        """Keysteps that are drawn from demonstrations, and what is joined of them."""
        if not self.settings.demonstrations:
            return (self.command_root,) if len(self.training) > 1 else ()
        return (*(self._keysteps(part.name) for part in self.training), self._keysteps("all"))

    @property
    def val_root(self) -> Path:
        """Keysteps of unseen scenes."""
        return self._keysteps(VAL)

    @property
    def training(self) -> list[Collection]:
        """The collections of the training split."""
        return list(self._collections())

    @property
    def val(self) -> Collection:
        """The collection of the validation split."""
        return Collection(VAL, self._collect_settings(self.tasks, self.settings.val_episodes, "val", 0))

    @property
    def episodes(self) -> int:
        """Demonstrations for training."""
        return sum(len(collection.settings) for collection in self.training)

    def collect(self) -> None:
        """Let the experts demonstrate; goes on where it was."""
        for collection in self.training:
            if self.settings.demonstrations:
                root = self.folder / "demonstrations" / collection.name
                targets = Targets(root, None, demonstrations_id=_repo_id(collection.name))
            else:
                targets = Targets(None, self._keysteps(collection.name), keysteps_id=_repo_id(collection.name))
            collect(collection.settings, targets, self.num_workers)
        collect(self.val.settings, Targets(None, self.val_root, keysteps_id=_repo_id(VAL)), self.num_workers)

    def draw_keysteps(self) -> None:
        """Draw the keysteps of all demonstrations, and join them for the command policy."""
        quieten()
        for collection in self.training if self.settings.demonstrations else []:
            root = self._keysteps(collection.name)
            unfinished = root.with_name(f".{root.name}")
            if root.exists():
                continue
            shutil.rmtree(unfinished, ignore_errors=True)
            name = _repo_id(collection.name)
            source = LeRobotDataset(name, root=self.folder / "demonstrations" / collection.name)
            convert(source, unfinished, name, balance=collection.settings.balance)
            unfinished.replace(root)
        if len(self.training) > 1:
            shutil.rmtree(self.command_root, ignore_errors=True)
            merge([self._keysteps(part.name) for part in self.training], self.command_root, _repo_id("all"))

    def _collections(self) -> Iterator[Collection]:
        counts, sequences = self.settings, {name: task.sequences for name, task in task_classes().items()}
        base = counts.action_episodes
        yield Collection(BASE, self._collect_settings(self.tasks, base, "train", 0))
        wanted = {False: counts.command_episodes, True: counts.multi_sequence_episodes}
        for several, name in ((False, "more_of_one_sequence"), (True, "more_of_several_sequences")):
            tasks = [task for task in self.tasks if (sequences[task] > 1) == several]
            if tasks and wanted[several] > base:
                settings = self._collect_settings(tasks, wanted[several] - base, "train", base * ATTEMPTS)
                yield Collection(name, settings)

    def _collect_settings(self, tasks: Sequence[str], episodes: int, split: str, first_seed: int) -> CollectSettings:
        training = split == "train"
        return CollectSettings(
            tuple(tasks),
            episodes,
            split,
            first_seed,
            balance=Balance(sampling_mode(self.settings.keystep_mode)),
            recovery=self.settings.recovery if training else 0.0,
            execution_noise=self.settings.execution_noise if training else 0.0,
        )

    def _keysteps(self, name: str) -> Path:
        return self.folder / "keysteps" / name


def _repo_id(name: str) -> str:
    return f"local/{name}"
