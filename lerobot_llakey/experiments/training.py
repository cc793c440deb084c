"""Training runs of LeRobot: what is typed, where they stand, and how they go on after having been ended."""

from __future__ import annotations

import functools
import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import draccus
import yaml
from lerobot.configs.train import TrainPipelineConfig

from lerobot_llakey.experiments.settings import TrainingSettings, find_config

_LAST = Path("checkpoints/last")
_BAR = re.compile(r"Training:[^\r\n]*?(\d+)/(\d+) \[")
_TAIL = 4096


@dataclass(frozen=True)
class Training:
    """One training.

    Attributes:
        name: of the run and its log.
        settings: recipe and what differs from it.
        repo_id: name of the dataset.
        root: its folder.
        output_dir: of the run.
        log: what the run prints.
        device: PyTorch's.
        launcher: words in place of python; none where empty.
    """

    name: str
    settings: TrainingSettings
    repo_id: str
    root: Path
    output_dir: Path
    log: Path
    device: str = "cpu"
    launcher: str = ""

    @property
    def checkpoint(self) -> Path:
        """The last checkpoint's policy."""
        return self.output_dir / _LAST / "pretrained_model"

    @property
    def steps(self) -> int:
        """How long it is."""
        return int(self.settings.steps or self._recipe()["steps"])

    @property
    def batch_size(self) -> int:
        """Samples a step."""
        return int(self.settings.batch_size or self._recipe()["batch_size"])

    def config(self) -> TrainPipelineConfig:
        """What LeRobot makes of the arguments; takes a second."""
        recipe, *arguments = self.fresh_arguments()
        return draccus.parse(TrainPipelineConfig, recipe.partition("=")[2], args=arguments)

    def described(self) -> dict[str, Any]:
        """All that the trained policy depends on beside the data."""
        ours = {"steps": self.settings.steps, "batch_size": self.settings.batch_size}
        return {"recipe": self._recipe(), **ours, "arguments": self.settings.arguments, "device": self.device}

    def fresh_arguments(self) -> list[str]:
        """Arguments of ``lerobot-train`` from the beginning."""
        arguments = [
            f"--config_path={find_config(self.settings.recipe)}",
            f"--dataset.repo_id={self.repo_id}",
            f"--dataset.root={self.root}",
            f"--output_dir={self.output_dir}",
            f"--policy.device={self.device}",
        ]
        numbers = {"steps": 0, "batch_size": 0, "num_workers": -1, "save_freq": 0}
        for name, unset in numbers.items():
            if (value := getattr(self.settings, name)) != unset:
                arguments.append(f"--{name}={value}")
        return [*arguments, *self.settings.arguments]

    def arguments(self) -> list[str]:
        """Arguments of ``lerobot-train``, going on from the last checkpoint where there is one."""
        if self.steps_saved():
            return [f"--config_path={self.checkpoint / 'train_config.json'}", "--resume=true"]
        return self.fresh_arguments()

    def command_line(self) -> str:
        """What a person would type."""
        return shlex.join(["lerobot-train", *self.fresh_arguments()])

    def steps_saved(self) -> int:
        """Steps of the last checkpoint; 0 without one."""
        last = self.output_dir / _LAST
        return int(last.resolve().name) if (last / "pretrained_model" / "train_config.json").is_file() else 0

    def steps_logged(self, steps: int) -> int:
        """How far the run that writes the log has come, of so many steps."""
        if not self.log.is_file():
            return 0
        with self.log.open("rb") as file:
            file.seek(max(0, self.log.stat().st_size - _TAIL))
            found = _BAR.findall(file.read().decode(errors="replace"))
        return steps - int(found[-1][1]) + int(found[-1][0]) if found else 0

    def last_words(self) -> str:
        """The last line of the log that tells of an error; the last one at all where none does."""
        text = self.log.read_text(errors="replace") if self.log.is_file() else ""
        lines: Sequence[str] = [line.strip() for line in re.split(r"[\r\n]+", text) if line.strip()]
        return next((line for line in reversed(lines) if "Error" in line), lines[-1] if lines else "")

    def _recipe(self) -> dict[str, Any]:
        return _read(find_config(self.settings.recipe))


@functools.cache
def _read(recipe: Path) -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load(recipe.read_text())
    return content
