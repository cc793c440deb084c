"""Records survive what a killed process leaves behind."""

from pathlib import Path

import pytest

from lerobot_llakey.evaluation.protocol.plan import Trial
from lerobot_llakey.evaluation.protocol.records import COMMAND, Record, Records
from lerobot_llakey.rollout.episode import Episode


def _record(episode: int) -> Record:
    action = [0.1 + 0.2, -1e-9, 1 / 3, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0]
    done = Episode("open_drawer", "öffne", episode, 0, 0, False, ["grasp it"], [""], ["pull"], [action], True)
    return Record(Trial("a", "open_drawer", "drop", 0, episode, episode), done, COMMAND, 0, 1.5)


def test_a_record_reads_as_it_was_written() -> None:
    record = _record(3)
    assert "\n" not in record.to_line() and Record.from_line(record.to_line()) == record


@pytest.mark.parametrize("share", [0.01, 0.5, 0.999])
def test_a_half_written_line_is_cut_off(tmp_path: Path, share: float) -> None:
    path = tmp_path / "episodes.jsonl"
    records = Records(path)
    records.add(_record(0))
    records.add(_record(1))
    whole = path.read_bytes()
    line = (_record(2).to_line() + "\n").encode()
    left = whole + line[: max(1, int(share * len(line)))]
    path.write_bytes(left)
    again = Records(path)
    assert len(again) == 2 and path.read_bytes() == left
    assert _record(2).trial not in again and _record(1).trial in again
    again.add(_record(2))
    assert list(Records(path)) == [_record(0), _record(1), _record(2)]


def test_no_episode_counts_twice(tmp_path: Path) -> None:
    path = tmp_path / "episodes.jsonl"
    records = Records(path)
    records.add(_record(0))
    with pytest.raises(ValueError, match="each episode once"):
        records.add(_record(0))
    path.write_bytes(path.read_bytes() * 2)
    assert len(Records(path)) == 1


def test_a_foreign_line_is_told(tmp_path: Path) -> None:
    path = tmp_path / "episodes.jsonl"
    path.write_text('{"trial": 3}\n')
    with pytest.raises(ValueError, match="Expected the record of an episode"):
        Records(path)
