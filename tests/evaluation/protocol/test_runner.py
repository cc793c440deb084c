"""What is done is not done again."""

from collections.abc import Iterator
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path

import pytest

from fakes_records import PLAN, ROWS, made_up_records
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol import runner
from lerobot_llakey.evaluation.protocol.plan import Plan, Trial
from lerobot_llakey.evaluation.protocol.records import Record, Records
from lerobot_llakey.evaluation.protocol.rows import Row

RECORDS = {record.trial: record for record in made_up_records(PLAN)}


def test_only_episodes_without_a_record_are_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ran: list[tuple[Row, Trial]] = []

    def run_trial(row: Row, plan: Plan, trial: Trial) -> Record:
        ran.append((row, trial))
        return RECORDS[trial]

    monkeypatch.setattr(runner, "run_trial", run_trial)
    path = tmp_path / "episodes.jsonl"
    begun = Records(path)
    for record in list(RECORDS.values())[:5]:
        begun.add(record)
    runner.run_missing(PLAN, ROWS, Records(path), 1)
    assert [trial for _, trial in ran] == list(RECORDS)[5:]
    assert all(row.name == trial.row for row, trial in ran)
    runner.run_missing(PLAN, ROWS, Records(path), 1)
    assert len(ran) == len(RECORDS) - 5 and len(Records(path)) == len(RECORDS)


def test_a_killed_process_is_told_and_what_was_done_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def dies(*_: object, **__: object) -> Iterator[Record]:
        yield next(iter(RECORDS.values()))
        raise BrokenProcessPool

    monkeypatch.setattr(runner, "run_jobs", dies)
    with pytest.raises(LlakeyError, match="got one killed, perhaps for want of memory"):
        runner.run_missing(PLAN, ROWS, Records(tmp_path / "episodes.jsonl"), 2)
    assert len(Records(tmp_path / "episodes.jsonl")) == 1


def test_videos_that_are_there_are_not_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[Path] = []

    def make_video(plan: Plan, record: Record, path: Path, detailed: bool) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        made.append(path)

    monkeypatch.setattr(runner, "make_video", make_video)
    records = Records(tmp_path / "episodes.jsonl")
    for record in RECORDS.values():
        records.add(replace(record, seconds=1.0))
    paths = runner.make_missing_films(PLAN, ROWS[:1], records, tmp_path / "videos", 1, False, 1)
    assert made == paths and {path.parent.name for path in paths} == {ROWS[0].slug}
    paths[0].unlink()
    assert runner.make_missing_films(PLAN, ROWS[:1], records, tmp_path / "videos", 1, False, 1) == paths
    assert made[len(paths) :] == paths[:1]
