"""What is left, from the episodes that are done or from ones run for the purpose."""

from pathlib import Path

import pytest

from lerobot_llakey.evaluation.protocol import estimate as module
from lerobot_llakey.evaluation.protocol.estimate import Estimate, estimate
from lerobot_llakey.evaluation.protocol.plan import Plan, Trial
from lerobot_llakey.evaluation.protocol.records import Record, Records
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.rollout.episode import Episode

PLAN = Plan(("open_drawer", "close_jar"), num_episodes=3, repeats=2)
ROWS = [Row("measured", "x"), Row("unknown", "y")]


def finished(trial: Trial, seconds: float) -> Record:
    return Record(trial, Episode(trial.task, "", trial.scene, 0, 0, True), "", None, seconds)


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[Trial]:
    """The trials that were run to measure, each of which takes 10 s, or 20 in close_jar."""
    trials: list[Trial] = []

    def run_trial(row: Row, plan: Plan, trial: Trial) -> Record:
        trials.append(trial)
        return finished(trial, 10.0 if trial.task == "open_drawer" else 20.0)

    monkeypatch.setattr(module, "run_trial", run_trial)
    return trials


def test_rows_with_episodes_are_not_measured_again(tmp_path: Path, ran: list[Trial]) -> None:
    records = Records(tmp_path / "episodes.jsonl")
    for trial in PLAN.trials(ROWS[:1])[:4]:
        records.add(finished(trial, 3.0))
    found = estimate(PLAN, ROWS[:1], records, num_workers=2)
    assert not ran
    assert found == Estimate(12, 4, {"measured": (8, 3.0)}, 2) and found.seconds == 12.0


def test_each_task_of_an_unknown_row_is_measured_once_and_leaves_no_record(tmp_path: Path, ran: list[Trial]) -> None:
    records = Records(tmp_path / "episodes.jsonl")
    found = estimate(PLAN, ROWS[1:], records, num_workers=4)
    assert len(records) == 0
    assert {trial.task for trial in ran[1:]} == set(PLAN.tasks) and len(ran) == 3  # the first one loads
    assert found.by_row == {"unknown": (12, 15.0)} and found.seconds == 45.0
    assert "12 episodes, 0 done; about 45 s" in str(found) and "unknown: 12 left, 15.0 s each" in str(found)


def test_a_finished_row_costs_nothing(tmp_path: Path, ran: list[Trial]) -> None:
    records = Records(tmp_path / "episodes.jsonl")
    for trial in PLAN.trials(ROWS[:1]):
        records.add(finished(trial, 3.0))
    found = estimate(PLAN, ROWS[:1], records, num_workers=0)
    assert found.seconds == 0.0 and found.processes == 1 and not ran
