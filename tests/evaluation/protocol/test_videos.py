"""Which episodes are recorded, and where their videos lie. What is recorded is tested where tables are run."""

from dataclasses import replace
from pathlib import Path

from fakes_records import PLAN, ROWS, made_up_records
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.videos import choose, video_path


def test_the_first_of_each_outcome_are_chosen() -> None:
    records = made_up_records(PLAN)
    chosen = choose(reversed(records), count=2)
    groups = [(one.trial.row, one.trial.task, one.episode.success) for one in chosen]
    assert groups.count(("ours", "open_drawer", True)) == groups.count(("ours", "open_drawer", False)) == 2
    assert groups.count(("ours", "close_jar", False)) == 0  # all are solved
    failures = [one.trial for one in chosen if one.trial.row == "ours" and not one.episode.success]
    assert [(trial.repeat, trial.episode) for trial in failures] == [(0, 0), (0, 1)]
    assert choose(records, count=0) == []


def test_episodes_that_no_event_struck_are_not_worth_seeing() -> None:
    plan = Plan(PLAN.tasks, 2, 4, disturbances=("drop",))
    assert choose(made_up_records(plan), 2) == []
    assert {one.trial.repeat for one in choose(made_up_records(plan, disturbed=True), 2)} <= {1, 2, 3}


def test_a_video_is_named_after_what_it_shows(tmp_path: Path) -> None:
    row, record = ROWS[0], made_up_records(PLAN)[0]
    name = video_path(tmp_path, row, record).relative_to(tmp_path)
    assert name == Path(row.slug) / f"open_drawer_0_00_failure_{record.attribution}.mp4"
    solved = replace(record, episode=replace(record.episode, success=True), attribution="")
    assert video_path(tmp_path, row, solved).name == "open_drawer_0_00_success.mp4"
    struck = replace(solved, trial=replace(record.trial, disturbance="drop"))
    assert video_path(tmp_path, row, struck).name == "open_drawer_drop_0_00_success.mp4"
