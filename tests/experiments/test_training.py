"""What is typed for a training, where it stands, and how it goes on."""

from pathlib import Path

import pytest

from lerobot_llakey.experiments.settings import TrainingSettings
from lerobot_llakey.experiments.training import Training


@pytest.fixture
def training(tmp_path: Path) -> Training:
    settings = TrainingSettings("configs/action_small.yaml", steps=30, arguments=["--policy.view_size=64"])
    return Training("action", settings, "local/base", tmp_path / "data", tmp_path / "out", tmp_path / "action.log")


def test_the_arguments_are_lerobots(training: Training) -> None:
    config = training.config()
    assert (config.steps, config.policy.view_size) == (30, 64)
    assert config.dataset.repo_id == "local/base" and config.output_dir == training.output_dir
    assert (training.steps, training.batch_size) == (config.steps, config.batch_size)
    assert training.command_line().startswith("lerobot-train --config_path=")


def test_it_goes_on_from_its_last_checkpoint(training: Training) -> None:
    assert training.steps_saved() == 0 and training.arguments() == training.fresh_arguments()
    saved = training.output_dir / "checkpoints" / "000020" / "pretrained_model"
    saved.mkdir(parents=True)
    (saved / "train_config.json").write_text("{}")
    (training.output_dir / "checkpoints" / "last").symlink_to("000020")
    assert training.steps_saved() == 20
    assert training.arguments() == [f"--config_path={training.checkpoint / 'train_config.json'}", "--resume=true"]


def test_its_progress_is_read_from_its_log(training: Training) -> None:
    assert training.steps_logged(30) == 0
    training.log.write_text(
        "INFO start\nTraining:  10%|#  | 2/20 [00:01<00:09]\rTraining:  25%|## | 5/20 [00:02<00:08]"
    )
    assert training.steps_logged(20) == 5
    assert training.steps_logged(30) == 15, "a run that went on counts what it has left only"
    assert training.last_words().startswith("Training:  25%")
    training.log.write_text("ValueError: Expected a view\nTraining:  25%|## | 5/20 [00:02<00:08]")
    assert training.last_words() == "ValueError: Expected a view"


def test_the_recipe_is_among_its_settings(training: Training) -> None:
    described = training.described()
    assert described["recipe"]["policy"]["type"] == "llakey_action" and described["steps"] == 30
