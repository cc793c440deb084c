"""The machine is measured once for a folder and its trainings."""

from pathlib import Path

import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.experiments import measure
from lerobot_llakey.experiments.measure import measured
from lerobot_llakey.experiments.rates import Rates
from lerobot_llakey.experiments.settings import TrainingSettings
from lerobot_llakey.experiments.training import Training

TINY = ["--policy.view_size=32", "--policy.widths=[16,24,32]", "--policy.text_width=32", "--policy.transformer_heads=2"]


def training(recipe: str, *arguments: str) -> Training:
    settings = TrainingSettings(f"configs/{recipe}.yaml", 10, 2, 0, 0, list(arguments))
    return Training(recipe, settings, "local/x", Path("x"), Path("out"), Path("x.log"))


def test_rates_are_measured_once_and_again_where_something_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[str] = []

    def fake(task: str, *_: object) -> Rates:
        calls.append(task)
        return Rates(demonstration=len(calls), step={"action": 0.5})

    monkeypatch.setattr(measure, "_measure", fake)
    trainings = {"action": training("action_small")}
    first = measured(tmp_path / "new", ["open_drawer"], trainings, "command", "action")
    assert measured(tmp_path / "new", ["open_drawer"], trainings, "command", "action") == first
    assert first == Rates(demonstration=1, step={"action": 0.5}) and calls == ["open_drawer"]
    other = {"action": training("action_small", "--policy.view_size=32")}
    assert measured(tmp_path / "new", ["open_drawer"], other, "command", "action").demonstration == 2
    assert measured(tmp_path / "new", ["close_jar"], other, "command", "action").demonstration == 3


def test_a_broken_record_is_named(tmp_path: Path) -> None:
    (tmp_path / "measured.json").write_text('{"of": ')
    with pytest.raises(LlakeyError, match=r"Expected a readable record of rates at .*measured\.json"):
        measured(tmp_path, ["open_drawer"], {}, "command", "action")


@pytest.mark.slow
def test_everything_that_a_stage_is_made_of_takes_time(tmp_path: Path) -> None:
    trainings = {"action": training("action_small", *TINY), "command": training("command_small")}
    rates = measured(tmp_path, ["open_drawer"], trainings, "command", "action")
    assert set(rates.step) == set(trainings)
    times = (rates.demonstration, rates.keysteps, rates.keystep_episode, rates.action, rates.answer, rates.video)
    assert min(*times, *rates.step.values()) > 0
