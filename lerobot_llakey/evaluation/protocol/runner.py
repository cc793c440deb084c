"""Runs what is missing of a table, and keeps what is done."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from tqdm import tqdm

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.records import Records
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.evaluation.protocol.shards import trials_of
from lerobot_llakey.evaluation.protocol.videos import choose, make_video, video_path
from lerobot_llakey.evaluation.protocol.work import run_trial
from lerobot_llakey.parallel import PROCESSES, run_jobs
from lerobot_llakey.shards import WHOLE, Shard

VIDEOS = "videos"


def run_missing(
    plan: Plan,
    rows: Sequence[Row],
    records: Records,
    num_workers: int,
    engine: str = PROCESSES,
    shard: Shard = WHOLE,
) -> None:
    """Run all episodes that have no record yet, showing progress.

    Args:
        plan: the protocol.
        rows: to run.
        records: of the episodes that are done; grows.
        num_workers: processes; one for each CPU core where 0, none but this one where 1.
        engine: where the episodes run, as in :func:`lerobot_llakey.parallel.run_jobs`.
        shard: of all episodes.

    Raises:
        LlakeyError: if a process is killed; what was done before is kept.
        RuntimeError: if an episode fails; see :func:`run_trial`.
    """
    by_name = {row.name: row for row in rows}
    trials = trials_of(plan, rows, shard)
    jobs = [(by_name[trial.row], plan, trial) for trial in trials if trial not in records]
    solved = sum(record.episode.success for record in records)
    with tqdm(total=len(trials), initial=len(trials) - len(jobs), desc="episodes", unit="episode") as progress:
        try:
            for record in run_jobs(run_trial, jobs, num_workers, engine=engine):
                records.add(record)
                solved += record.episode.success
                progress.set_postfix(row=record.trial.row, solved=f"{solved}/{len(records)}", refresh=False)
                progress.update()
        except BrokenProcessPool as error:
            raise LlakeyError(
                "Expected the processes to live until their episodes are done, got one killed, perhaps for want of "
                "memory; start again with a smaller --num_workers, what is done is kept."
            ) from error


def make_missing_films(
    plan: Plan, rows: Sequence[Row], records: Records, folder: Path, count: int, detailed: bool, num_workers: int
) -> list[Path]:
    """Make the videos that are not there yet.

    Args:
        plan: the protocol.
        rows: of the table.
        records: of all episodes.
        folder: of the videos.
        count: successes and failures of each row, task and event to show; none where 0.
        detailed: show the robot's detailed meshes.
        num_workers: as in :func:`run_missing`.

    Returns:
        The paths of all videos.
    """
    by_name = {row.name: row for row in rows}
    chosen = [record for record in choose(records, count) if record.trial.row in by_name]
    paths = [video_path(folder, by_name[record.trial.row], record) for record in chosen]
    jobs = [(plan, record, path, detailed) for record, path in zip(chosen, paths, strict=True) if not path.exists()]
    for _ in tqdm(run_jobs(make_video, jobs, num_workers), total=len(jobs), desc="videos", unit="video"):
        pass
    return paths
