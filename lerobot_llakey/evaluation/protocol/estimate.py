"""How long a table will take here, from a short measurement."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

from lerobot_llakey.evaluation.protocol.plan import Plan, Trial
from lerobot_llakey.evaluation.protocol.records import Records
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.evaluation.protocol.shards import trials_of
from lerobot_llakey.evaluation.protocol.work import run_trial
from lerobot_llakey.parallel import PROCESSES, count_workers
from lerobot_llakey.reporting.durations import clock
from lerobot_llakey.shards import WHOLE, Shard

_MEASURE_SECONDS = 60.0
"""How long each row is measured; the episode that is under way then is finished."""


@dataclass(frozen=True)
class Estimate:
    """What is still to be done.

    Attributes:
        episodes: of the whole table.
        done: of these.
        by_row: for each row the episodes that are left and the seconds of one.
        processes: that will share the work.
    """

    episodes: int
    done: int
    by_row: dict[str, tuple[int, float]]
    processes: int

    @property
    def seconds(self) -> float:
        """That the rest takes, all processes busy; loading and the videos come on top."""
        return sum(count * seconds for count, seconds in self.by_row.values()) / self.processes

    def __str__(self) -> str:
        rows = [f"  {row}: {count} left, {seconds:.1f} s each" for row, (count, seconds) in self.by_row.items()]
        total = f"{self.episodes} episodes, {self.done} done; about {clock(self.seconds)} for the rest"
        return "\n".join([f"{total} with {self.processes} processes, videos not counted", *rows])


def estimate(
    plan: Plan,
    rows: Sequence[Row],
    records: Records,
    num_workers: int,
    engine: str = PROCESSES,
    shard: Shard = WHOLE,
) -> Estimate:
    """Measure one episode of each task, task by task until a minute has passed, for each row that is not done.

    Episodes that are done already count as measured; those run here leave no record.

    Args:
        plan: the protocol.
        rows: to run.
        records: of the episodes that are done.
        num_workers: processes; one for each CPU core where 0.
        engine: where the episodes will run; they are measured here.
        shard: of all episodes.
    """
    trials = trials_of(plan, rows, shard)
    by_row: dict[str, tuple[int, float]] = {}
    for row in rows:
        left = [trial for trial in trials if trial.row == row.name and trial not in records]
        known = [record.seconds for record in records if record.trial.row == row.name]
        by_row[row.name] = (len(left), fmean(known or _measure(plan, row, left)) if left else 0.0)
    processes = min(count_workers(num_workers, engine), max(1, len(trials) - len(records)))
    return Estimate(len(trials), len(records), by_row, processes)


def _measure(plan: Plan, row: Row, trials: Sequence[Trial]) -> list[float]:
    firsts = {(trial.task, trial.disturbance): trial for trial in reversed(trials)}
    run_trial(row, plan, trials[0])  # loads what is used from then on
    seconds: list[float] = []
    start = time.perf_counter()
    for trial in reversed(firsts.values()):
        if seconds and time.perf_counter() - start > _MEASURE_SECONDS:
            break
        seconds.append(run_trial(row, plan, trial).seconds)
    return seconds
