"""The torture in small: killed once, finished, and a second collector refused."""

from pathlib import Path

import pytest

from torture.kills import Outcome, kill_collecting
from torture.second import second_collector

OPTIONS = ("--task=open_drawer", "--num_episodes=4", "--num_workers=1")


def test_a_loss_is_told() -> None:
    assert Outcome(kills=3).good
    outcome = Outcome(lost=["0000000-0000004"])
    assert not outcome.good and "1 parts lost" in str(outcome) and "0000000-0000004" in str(outcome)


@pytest.mark.slow
def test_a_killed_run_loses_nothing_and_a_second_one_is_refused(tmp_path: Path) -> None:
    status, sentence, first = second_collector(tmp_path / "second", OPTIONS)
    assert (status, first) == (1, 0) and sentence.startswith("error: Expected no other run in")
    outcome = kill_collecting(tmp_path / "kills", 1, 0, OPTIONS, longest=1.0)
    assert outcome.good and outcome.kills == 1, str(outcome)
