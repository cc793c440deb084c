"""A second collector on a folder in which one is at work."""

from __future__ import annotations

import signal
import subprocess
import time
from pathlib import Path

from torture.kills import command


def second_collector(folder: Path, options: tuple[str, ...]) -> tuple[int, str, int]:
    """Start a run, then another on the same folders.

    Returns:
        Exit status of the second and what it says; exit status of the first.
    """
    targets = folder / "demonstrations", folder / "keysteps"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    first = subprocess.Popen(command(*targets, *options), **quiet)  # type: ignore[call-overload]
    while first.poll() is None and not list(Path(f"{targets[0]}.parts").glob("unfinished-*")):
        time.sleep(0.05)
    first.send_signal(signal.SIGSTOP)  # at work for as long as the second one takes to start
    second = subprocess.run(command(*targets, *options), capture_output=True, text=True)
    first.send_signal(signal.SIGCONT)
    return second.returncode, second.stderr.strip().rpartition("\n")[2], first.wait()
