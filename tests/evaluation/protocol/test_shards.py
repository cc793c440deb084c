"""A table run in shards is the table."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from fakes_protocol import small_env
from lerobot_llakey import parallel
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.experiment import Output, report_table, run_experiment, run_shard
from lerobot_llakey.evaluation.protocol import runner, work
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.records import EPISODES, Records
from lerobot_llakey.evaluation.protocol.rows import EXPERT, Row
from lerobot_llakey.evaluation.protocol.shards import shard_folder, trials_of
from lerobot_llakey.files import alone_in
from lerobot_llakey.shards import Shard

PLAN = Plan(("open_drawer",), num_episodes=2, repeats=2)
ROWS = [Row("expert", EXPERT)]


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parallel, "_kept", {})
    monkeypatch.setattr(work, "LlakeySimEnv", small_env)


def _output(folder: Path) -> Output:
    return Output(folder, num_videos=0, num_workers=1)


def _trials(path: Path) -> list[str]:
    return sorted(json.dumps(json.loads(line)["trial"]) for line in path.read_text().splitlines())


def test_shards_are_put_together_and_nothing_is_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shards = [Shard(number, 3) for number in (3, 1, 2)]
    for shard in shards:
        folder = run_shard(PLAN, ROWS, _output(tmp_path / "shards"), shard)
        assert [record.trial for record in Records(folder / EPISODES)] == trials_of(PLAN, ROWS, shard)
        assert not (folder / "table.md").exists()
    run_experiment(PLAN, ROWS, _output(tmp_path / "one"), report_table)

    def again(*_: object) -> None:
        raise AssertionError("an episode that a shard has done was run again")

    monkeypatch.setattr(runner, "run_trial", again)
    for _ in range(2):
        run_experiment(PLAN, ROWS, _output(tmp_path / "shards"), report_table)
    assert (tmp_path / "shards" / "table.md").read_text() == (tmp_path / "one" / "table.md").read_text()
    assert _trials(tmp_path / "shards" / EPISODES) == _trials(tmp_path / "one" / EPISODES)
    together = {record.trial: record.episode for record in Records(tmp_path / "shards" / EPISODES)}
    assert together == {record.trial: record.episode for record in Records(tmp_path / "one" / EPISODES)}


def test_what_no_shard_has_done_is_run_by_the_table(tmp_path: Path) -> None:
    for shard in (Shard(1, 4), Shard(1, 2)):  # overlapping
        run_shard(PLAN, ROWS, _output(tmp_path), shard)
    run_experiment(PLAN, ROWS, _output(tmp_path), report_table)
    assert len(_trials(tmp_path / EPISODES)) == len(set(_trials(tmp_path / EPISODES))) == PLAN.episodes_a_row


def test_shards_that_are_running_of_other_settings_or_too_many_are_refused(tmp_path: Path) -> None:
    folder = run_shard(PLAN, ROWS, _output(tmp_path), Shard(1, 4))
    with alone_in(folder):
        with pytest.raises(LlakeyError, match="Expected no other run in"):
            run_shard(PLAN, ROWS, _output(tmp_path), Shard(1, 4))
        with pytest.raises(LlakeyError, match="Expected no other run in"):
            run_experiment(PLAN, ROWS, _output(tmp_path), report_table)
    other = replace(PLAN, first_seed=100)
    with pytest.raises(LlakeyError, match="got a change of first_seed"):
        run_shard(other, ROWS, _output(tmp_path), Shard(1, 4))
    (tmp_path / "settings.json").unlink()
    with pytest.raises(LlakeyError, match="got a change of first_seed"):
        run_experiment(other, ROWS, _output(tmp_path), report_table)
    with pytest.raises(LlakeyError, match="at most 4 shards"):
        run_shard(PLAN, ROWS, _output(tmp_path), Shard(5, 5))
    assert not shard_folder(tmp_path, Shard(5, 5)).exists()
