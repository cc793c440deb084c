"""Running cases, each in a process of its own that is bounded in time and memory."""

from __future__ import annotations

import contextlib
import os
import pickle
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from fuzz.case import Case, Outcome, judge

SECONDS = 90.0
"""Longer than this is a hang."""
MEMORY = 4 * 2**30
"""Bytes that a case may ask for beyond what its parent holds."""


def run_cases(cases: Sequence[Case], workers: int) -> Iterator[Outcome]:
    """Run cases side by side.

    Args:
        cases: what to run.
        workers: how many at once.

    Yields:
        Outcomes in the order in which they end.
    """
    waiting, running = list(cases), {}
    while waiting or running:
        while waiting and len(running) < workers:
            case = waiting.pop(0)
            folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
            running[_start(case, folder)] = (case, folder, time.monotonic())
        for process, (case, folder, start) in list(running.items()):
            done, status = os.waitpid(process, os.WNOHANG)
            if done:
                del running[process]
                yield _outcome(case, folder, status, time.monotonic() - start)
            elif time.monotonic() - start > SECONDS:
                os.killpg(process, signal.SIGKILL)
        time.sleep(0.02)


def _start(case: Case, folder: Path) -> int:
    process = os.fork()
    if process:
        return process
    os.setsid()  # so that its own children end with it
    try:
        held = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        resource.setrlimit(resource.RLIMIT_AS, (held + MEMORY, held + MEMORY))
        output = os.open(folder / "said", os.O_WRONLY | os.O_CREAT)
        for stream in (0, 1, 2):
            os.dup2(os.open(os.devnull, os.O_RDONLY) if stream == 0 else output, stream)
        _act(case, folder)
    finally:
        os._exit(0)


def _act(case: Case, folder: Path) -> None:
    scratch = folder / "scratch"
    scratch.mkdir()
    os.chdir(scratch)
    raised, answer = None, None
    try:
        answer = case.act(scratch)
    except BaseException as error:
        raised = error
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
    said = (folder / "said").read_text(errors="replace")
    (folder / "result").write_bytes(pickle.dumps(judge(case, raised, answer, said)))


def _outcome(case: Case, folder: Path, status: int, seconds: float) -> Outcome:
    path = folder / "result"
    if path.exists():
        result, text = pickle.loads(path.read_bytes())
    else:
        result = "hang" if seconds > SECONDS else "signal"
        text = f"status {status}: {(folder / 'said').read_text(errors='replace')[-300:]}"
    shutil.rmtree(folder, ignore_errors=True)
    return Outcome(case, result, text, seconds)
