"""Which policies a reproduction trains, and which rows of the tables they make."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.experiments.data import Data
from lerobot_llakey.experiments.settings import TableSettings, TrainingSettings, TrainSettings
from lerobot_llakey.experiments.training import Training

ACTION, COMMAND = "train_action", "train_command"
BASELINE, ONE_VIEW, DIRECT = "train_baseline", "train_one_view", "train_direct"
LLAKEY_ROW, BASELINE_ROW = "LLaKey (3 views)", "baseline (skill instruction, timestep)"


@dataclass(frozen=True)
class Policies:
    """The trainings of a reproduction and what is made of them.

    Args:
        settings: what is trained.
        data: the datasets.
        folder: of the reproduction.
        device: PyTorch's.

    Raises:
        LlakeyError: if the action or the command policy has no recipe.
    """

    settings: TrainSettings
    data: Data
    folder: Path
    device: str = "cpu"

    def __post_init__(self) -> None:
        if not (self.settings.action.recipe and self.settings.command.recipe):
            raise LlakeyError("Expected recipes for train.action and train.command, got none; name YAML files.")

    @property
    def trainings(self) -> dict[str, Training]:
        """By the name of the stage; those without a recipe are left out."""
        settings, actions, commands = self.settings, self.data.action_root, self.data.command_root
        wanted = {
            ACTION: self._training("action", settings.action, actions),
            COMMAND: self._training("command", settings.command, commands),
            BASELINE: self._training("baseline", settings.baseline, actions),
            ONE_VIEW: self._training("one_view", settings.one_view, commands),
            DIRECT: self._training("direct", settings.direct, commands),
        }
        return {name: training for name, training in wanted.items() if training.settings.recipe}

    @property
    def llakey(self) -> Path:
        """The checkpoint composed of both levels."""
        return self.folder / "policies" / "llakey"

    def rows(self, table: TableSettings) -> list[Row]:
        """The rows of table I."""
        trainings = self.trainings
        rows = [
            Row(LLAKEY_ROW, str(self.llakey), paper="LLaKey 13B (3)"),
            Row("LLaKey with the oracle's instructions", str(self.llakey), overrides={"commander": "oracle"}),
        ]
        action = str(trainings[ACTION].checkpoint)
        if ONE_VIEW in trainings:
            command = str(trainings[ONE_VIEW].checkpoint)
            rows.insert(1, Row("LLaKey (1 view)", command_path=command, action_path=action))
        if BASELINE in trainings:
            rows.append(Row(BASELINE_ROW, str(trainings[BASELINE].checkpoint), paper="RVT"))
        if DIRECT in trainings:
            rows.append(Row("direct action prediction", str(trainings[DIRECT].checkpoint)))
        if table.chat_url:
            chat = {"backend": "chat", "base_url": table.chat_url, "model": table.chat_model}
            overrides = {f"command.{name}": value for name, value in chat.items()}
            rows.append(Row("chat model", action_path=action, overrides=overrides))
        return rows

    def rollback_rows(self) -> list[Row]:
        """The rows of figure 6."""
        return [row for row in self.rows(TableSettings()) if row.name in (LLAKEY_ROW, BASELINE_ROW)]

    def commanders(self) -> dict[str, Path]:
        """The command policies whose abilities are measured, by name."""
        trainings = self.trainings
        names = {"3 views": COMMAND, "1 view": ONE_VIEW}
        return {name: trainings[stage].checkpoint for name, stage in names.items() if stage in trainings}

    def _training(self, name: str, settings: TrainingSettings, root: Path) -> Training:
        return Training(
            name,
            settings,
            f"local/{root.name}",
            root,
            self.folder / "policies" / name,
            self.folder / "logs" / f"{name}.log",
            self.device,
            self.settings.launcher,
        )
