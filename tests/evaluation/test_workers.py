"""Jobs run here or in other processes."""

import os

import pytest

from lerobot_llakey.evaluation.workers import run_jobs, world_of


@pytest.mark.parametrize("num_workers", [1, 2])
def test_every_job_is_done_once(num_workers: int) -> None:
    jobs = [(2, power) for power in range(5)]
    assert sorted(run_jobs(pow, jobs, num_workers)) == [1, 2, 4, 8, 16]


def test_processes_are_as_many_as_asked_for() -> None:
    assert set(run_jobs(os.getpid, [()] * 3, 1)) == {os.getpid()}
    assert os.getpid() not in set(run_jobs(os.getpid, [()] * 3, 2))


def test_a_scene_is_built_once() -> None:
    assert world_of("move_block") is world_of("move_block")
