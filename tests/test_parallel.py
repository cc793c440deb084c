"""Jobs run here or in other processes."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from lerobot_llakey.parallel import kept, run_jobs, tell


@pytest.mark.parametrize("num_workers", [1, 2])
def test_every_job_is_done_once(num_workers: int) -> None:
    jobs = [(2, power) for power in range(5)]
    assert sorted(run_jobs(pow, jobs, num_workers)) == [1, 2, 4, 8, 16]


def test_processes_are_as_many_as_asked_for() -> None:
    assert set(run_jobs(os.getpid, [()] * 3, 1)) == {os.getpid()}
    assert os.getpid() not in set(run_jobs(os.getpid, [()] * 3, 2))


@pytest.mark.parametrize("num_workers", [1, 2])
def test_what_jobs_tell_on_their_way_is_heard(num_workers: int) -> None:
    heard: list[int] = []
    assert list(run_jobs(tell, [(1,), (2,), (3,)], num_workers, heard.append)) == [None] * 3
    assert sorted(heard) == [1, 2, 3]
    assert list(run_jobs(tell, [(4,)], num_workers)) == [None] and len(heard) == 3


def test_the_last_thing_made_is_kept_and_closed_when_another_takes_its_place() -> None:
    closed: list[str] = []

    class Scene:
        def __init__(self, name: str) -> None:
            self.name = name

        def close(self) -> None:
            closed.append(self.name)

    first = kept(Scene, "first")
    assert kept(Scene, "first") is first and not closed
    second = kept(Scene, "second")
    assert closed == ["first"] and kept(Scene, "second") is second
    assert kept(Scene, "first") is not first and closed == ["first", "second"]


_ORPHANS = """
import os, sys, time
from pathlib import Path
sys.path.insert(0, {folder!r})
from lerobot_llakey.parallel import run_jobs
import sleepers

if __name__ == "__main__":
    list(run_jobs(sleepers.sleep, [({folder!r},)] * 2, 2))
"""
_SLEEPERS = """
import os, time
from pathlib import Path

def sleep(folder):
    Path(folder, f"{os.getpid()}.pid").touch()
    time.sleep(120)
"""


def test_no_process_outlives_a_killed_run(tmp_path: Path) -> None:
    (tmp_path / "sleepers.py").write_text(_SLEEPERS)
    (tmp_path / "main.py").write_text(_ORPHANS.format(folder=str(tmp_path)))
    run = subprocess.Popen([sys.executable, str(tmp_path / "main.py")], start_new_session=True)
    try:
        _until(lambda: len(list(tmp_path.glob("*.pid"))) == 2)
        workers = [int(path.stem) for path in tmp_path.glob("*.pid")]
        run.kill()
        run.wait()
        _until(lambda: not any(_alive(worker) for worker in workers))
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(run.pid, signal.SIGKILL)


def test_ctrl_c_ends_all_processes_at_once_and_says_nothing_of_theirs(tmp_path: Path) -> None:
    (tmp_path / "sleepers.py").write_text(_SLEEPERS)
    script = _ORPHANS.format(folder=str(tmp_path)).replace("    list(", "    try:\n        list(")
    (tmp_path / "main.py").write_text(f"{script}    except KeyboardInterrupt:\n        sys.exit(130)\n")
    run = subprocess.Popen(
        [sys.executable, str(tmp_path / "main.py")], start_new_session=True, stderr=subprocess.PIPE, text=True
    )
    try:
        _until(lambda: len(list(tmp_path.glob("*.pid"))) == 2)
        workers = [int(path.stem) for path in tmp_path.glob("*.pid")]
        os.killpg(run.pid, signal.SIGINT)  # as a terminal does
        _, said = run.communicate(timeout=300)
        assert run.returncode == 130 and "Traceback" not in said
        _until(lambda: not any(_alive(worker) for worker in workers))
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(run.pid, signal.SIGKILL)


def _alive(pid: int) -> bool:
    status = Path(f"/proc/{pid}/stat")
    return status.exists() and status.read_text().rpartition(")")[2].split()[0] != "Z"


def _until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 300  # a busy machine starts processes slowly
    while not condition():
        assert time.monotonic() < deadline, "waited for five minutes in vain"
        time.sleep(0.05)
