"""Collecting that is killed at random moments."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

from lerobot_llakey.datasets.digest import digest
from lerobot_llakey.datasets.parts import DISCARDED


@dataclass
class Outcome:
    """What came of it.

    Attributes:
        kills: that struck a run.
        runs: datasets that were finished.
        parts: finished ones that a kill found.
        lost: finished parts that were gone after a kill.
        differing: datasets unlike that of an undisturbed run.
        broken: runs that ended with an error.
    """

    kills: int = 0
    runs: int = 0
    parts: int = 0
    lost: list[str] = field(default_factory=list)
    differing: list[str] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)

    @property
    def good(self) -> bool:
        """Whether nothing was lost, doubled or broken."""
        return not (self.lost or self.differing or self.broken)

    def __str__(self) -> str:
        counts = f"{self.kills} kills, {self.runs} datasets finished, {self.parts} finished parts met by kills"
        found = f"{len(self.lost)} parts lost, {len(self.differing)} datasets differ, {len(self.broken)} runs broke"
        return f"{counts}; {found}" + "".join(f"\n  {line}" for line in (*self.lost, *self.differing, *self.broken))


def command(root: Path, keysteps: Path, *options: str) -> list[str]:
    """``llakey collect`` of a few small episodes."""
    return [
        *(sys.executable, "-m", "lerobot_llakey.cli.main", "collect", "--repo_id=local/x", "--split=val"),
        *(f"--root={root}", f"--keysteps_root={keysteps}", "--image_size=32", *options),
    ]


def finished_parts(root: Path) -> set[str]:
    """Names of the parts that count as finished."""
    return {path.parent.name for path in Path(f"{root}.parts").glob(f"*/{DISCARDED}") if path.parent.name[0].isdigit()}


def kill_collecting(folder: Path, kills: int, seed: int, options: tuple[str, ...], longest: float = 8.0) -> Outcome:
    """Kill ``llakey collect`` at random moments, start it again, and hold the result against an undisturbed run's.

    A moment is drawn from when the run begins to make parts, a fifth of them from when its process starts.

    Args:
        folder: to work in.
        kills: number of them; a dataset that is finished before is checked, and another one begun.
        seed: of the moments.
        options: of the verb.
        longest: seconds from then to a kill.
    """
    rng, outcome = random.Random(seed), Outcome()
    whole = folder / "whole" / "demonstrations", folder / "whole" / "keysteps"
    subprocess.run(command(*whole, *options), check=True, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    expected = [digest(root) for root in whole]
    while outcome.kills < kills:
        targets = tuple(folder / f"{outcome.runs}" / name for name in ("demonstrations", "keysteps"))
        while outcome.kills < kills and _struck(targets, options, rng, longest, outcome):
            pass
        ended = subprocess.run(
            command(*targets, *options), stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
        )
        outcome.runs += 1
        if ended.returncode:
            outcome.broken.append(ended.stderr[-300:])
        elif [digest(root) for root in targets] != expected:
            outcome.differing.append(str(targets[0]))
        left = {path.name for path in targets[0].parent.iterdir()} - {target.name for target in targets}
        if left - {f".{target.name}.lock" for target in targets}:
            outcome.broken.append(f"left behind: {sorted(left)}")
    return outcome


def _struck(
    targets: tuple[Path, ...], options: tuple[str, ...], rng: random.Random, longest: float, outcome: Outcome
) -> bool:
    """Start a run and kill it; False where it ended before."""
    before = finished_parts(targets[0])
    parts = Path(f"{targets[0]}.parts")
    known = _unfinished(parts)
    run = subprocess.Popen(
        command(*targets, *options),
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
    wait_for_parts = rng.random() > 0.2
    delay = rng.uniform(0, longest)
    while wait_for_parts and run.poll() is None and not _unfinished(parts) - known and not targets[1].exists():
        time.sleep(0.02)
    deadline = time.monotonic() + delay
    while run.poll() is None and time.monotonic() < deadline:
        time.sleep(0.005)
    met = finished_parts(targets[0])
    struck = run.poll() is None
    if struck:
        os.kill(run.pid, signal.SIGKILL)
        outcome.kills += 1
    _, told = run.communicate()
    if not struck:
        if run.returncode:
            outcome.broken.append(told[-300:])
        return False
    outcome.parts += len(met)
    if not targets[0].exists():
        outcome.lost += sorted((before | met) - finished_parts(targets[0]))
    return True


def _unfinished(parts: Path) -> set[str]:
    return {path.name for path in parts.glob("unfinished-*")}
