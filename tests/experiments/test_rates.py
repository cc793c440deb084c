"""What a plan says of its time follows from the rates."""

from dataclasses import fields, replace
from pathlib import Path

from lerobot_llakey.experiments.ambiguity import Ambiguity
from lerobot_llakey.experiments.rates import Rates
from lerobot_llakey.experiments.settings import AmbiguitySettings, TrainingSettings

TRAINING = TrainingSettings("configs/action_small.yaml", steps=10)
STAGES = Ambiguity(AmbiguitySettings(action=TRAINING, command=TRAINING, baseline=TRAINING), Path("nowhere")).stages()


def seconds(rates: Rates) -> float:
    return sum(stage.seconds(rates) for stage in STAGES if stage.training is None or "action" in stage.name)


def test_what_was_not_measured_takes_no_time() -> None:
    assert seconds(Rates()) == 0
    assert all(not getattr(Rates(), part.name) for part in fields(Rates) if part.name != "cores")


def test_more_processes_share_episodes_but_not_training() -> None:
    rates = Rates(keystep_episode=2.0, action=1.0, start=5.0, step={"ambiguity_action": 3.0})
    training = Rates(start=5.0, step={"ambiguity_action": 3.0})
    assert seconds(training) == 5 + 10 * 3 and seconds(rates) > seconds(training)
    alone = seconds(rates) - seconds(training)
    assert seconds(replace(rates, cores=4)) - seconds(training) == alone / 4
