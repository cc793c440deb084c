"""Jobs on a Ray cluster of two nodes, of which one is killed."""

import sys
from pathlib import Path

import pytest

from lerobot_llakey.datasets.plan import CollectSettings
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.parallel import RAY, run_jobs, tell
from torture.cluster import kill_on_cluster, two_nodes


def test_without_ray_a_sentence_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(LlakeyError, match=r"pip install 'lerobot_policy_llakey\[ray\]'"):
        list(run_jobs(pow, [(2, 3)], engine=RAY))


def _refuse() -> None:
    raise LlakeyError("Expected another day, got this one; wait.")


@pytest.mark.slow
@pytest.mark.cluster
def test_jobs_are_done_once_heard_once_and_survive_a_killed_process_and_a_killed_node(tmp_path: Path) -> None:
    pytest.importorskip("ray")
    with two_nodes() as cluster:
        jobs = [(2, power) for power in range(5)]
        assert sorted(run_jobs(pow, jobs, engine=RAY)) == [1, 2, 4, 8, 16]
        heard: list[int] = []
        assert list(run_jobs(tell, [(1,), (2,), (3,)], 2, heard.append, RAY)) == [None] * 3
        assert sorted(heard) == [1, 2, 3]
        with pytest.raises(LlakeyError, match=r"^Expected another day"):
            list(run_jobs(_refuse, [()], engine=RAY))
        settings = CollectSettings(("open_drawer", "move_block"), num_episodes=8, split="val", image_size=32)
        outcome = kill_on_cluster(cluster, tmp_path, 2, 0, settings, longest=1.0)
    assert outcome.good and outcome.kills == 2, str(outcome)
