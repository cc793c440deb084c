"""A training that is ended goes on from its last checkpoint; one that fails says why."""

import time
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import pytest

from fakes import fake_keysteps
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.experiments.settings import TrainingSettings
from lerobot_llakey.experiments.trainer import _Run, train_all
from lerobot_llakey.experiments.training import Training

SMALL = ["--policy.view_size=32", "--policy.widths=[16,24,32]", "--policy.text_width=32"]
SMALL += ["--policy.transformer_heads=2", "--log_freq=1"]


@pytest.mark.slow
def test_an_ended_training_goes_on_and_a_failing_one_says_why(tmp_path: Path) -> None:
    fake_keysteps(tmp_path / "data")
    settings = TrainingSettings("configs/action_small.yaml", 400, 2, 0, 1, SMALL)
    training = Training("tiny", settings, "llakey/fake", tmp_path / "data", tmp_path / "out", tmp_path / "tiny.log")
    run = _Run(training, get_context("forkserver"), 1, 0)
    while not training.steps_saved() and not run.over():
        time.sleep(0.05)
    run.end()
    saved = training.steps_saved()
    assert 0 < saved < 400, training.last_words()

    config = training.checkpoint / "train_config.json"  # a person who wants fewer steps, so that the test ends
    config.write_text(config.read_text().replace('"steps": 400', f'"steps": {saved + 2}'))
    done: list[tuple[float, float]] = []
    train_all([replace(training, settings=replace(settings, steps=saved + 2))], 1, lambda _, *spent: done.append(spent))
    assert training.steps_saved() == saved + 2 and done[0][1] > 0
    assert f"{saved + 2}/{saved + 2}" not in training.log.read_text(), "it began anew"

    wrong = replace(settings, arguments=[*SMALL, "--policy.views=[nowhere]"])
    broken = replace(training, settings=wrong, output_dir=tmp_path / "broken")
    with pytest.raises(LlakeyError, match="Expected the training tiny to reach step 400, got exit status 1"):
        train_all([broken], 1, lambda *_: None)
