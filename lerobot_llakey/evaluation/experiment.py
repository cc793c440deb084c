"""One experiment of the paper in one folder: episodes, figures, tables, plots and videos, resumable throughout."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lerobot_llakey.evaluation.lower_part import AbilitySamples, ability_page, measure_rows
from lerobot_llakey.evaluation.protocol import markdown, plots
from lerobot_llakey.evaluation.protocol.estimate import Estimate, estimate
from lerobot_llakey.evaluation.protocol.loading import Runnable, runnable
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.records import EPISODES, Records
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.evaluation.protocol.runner import VIDEOS, make_missing_films, run_missing
from lerobot_llakey.evaluation.protocol.settings import claim, settings_of
from lerobot_llakey.evaluation.protocol.shards import gather, shard_folder, trials_of
from lerobot_llakey.evaluation.protocol.summary import summarise_rollback, summarise_table
from lerobot_llakey.files import alone_in, write_whole
from lerobot_llakey.parallel import PROCESSES
from lerobot_llakey.reporting import paper_results
from lerobot_llakey.shards import WHOLE, Shard

TABLE = "table.md"


@dataclass(frozen=True)
class Output:
    """Where and how the results are left.

    Attributes:
        folder: for ``results.json``, ``table.md``, plots, ``videos/``, and what a run goes on from: ``settings.json``
            and ``episodes.jsonl``.
        num_videos: successes and failures of each row, task and event of which a video is made.
        detailed: show the robot's detailed meshes in them.
        num_workers: processes; one for each CPU core where 0.
        engine: where the episodes run, as in :func:`lerobot_llakey.parallel.run_jobs`; the videos are made here.
    """

    folder: Path
    num_videos: int = 2
    detailed: bool = False
    num_workers: int = 0
    engine: str = PROCESSES


Report = Callable[[Plan, Sequence[Row], Records, Mapping[str, str], Path], tuple[dict[str, Any], str]]
"""Draws the plots into a folder; returns figures for results.json and a page in Markdown."""


def run_experiment(
    plan: Plan, rows: Sequence[Row], output: Output, report: Report, samples: AbilitySamples | None = None
) -> str:
    """Run what is missing, then write everything.

    Started again after being killed it goes on where it was; once all is done it only writes the results again. What
    :func:`run_shard` has done in the folder counts as done.

    Args:
        plan: the protocol.
        rows: of the table; those without a checkpoint are left out and named.
        output: where the results go.
        report: :func:`report_table` or :func:`report_rollback`.
        samples: where the abilities of the rows' command policies are measured too; nowhere where None.

    Returns:
        The page in Markdown.

    Raises:
        MissingFileError: if no row has a checkpoint.
        LlakeyError: if the folder holds results of other settings, another run is in it, or a process is killed.
        RuntimeError: if an episode fails.
    """
    if samples is not None:
        samples.check()
    found = _found(rows)
    with alone_in(output.folder):
        settings = settings_of(plan, rows, found.missing)
        claim(output.folder, settings)
        records = Records(output.folder / EPISODES)
        if taken := gather(output.folder, settings, records):
            print(f"taken from shards: {taken} episodes")
        run_missing(plan, found.rows, records, output.num_workers, output.engine)
        figures, page = report(plan, found.rows, records, found.missing, output.folder)
        if samples is not None:
            figures["abilities"] = measure_rows(found.rows, samples, output.folder)
            page += f"\n{ability_page(plan.tasks, figures['abilities'])}"
        results = {"settings": settings, "missing": found.missing, **figures}
        write_whole(output.folder / "results.json", json.dumps(results, indent=2))
        write_whole(output.folder / TABLE, page)
        make_missing_films(
            plan,
            found.rows,
            records,
            output.folder / VIDEOS,
            output.num_videos,
            output.detailed,
            output.num_workers,
        )
    return page


def run_shard(plan: Plan, rows: Sequence[Row], output: Output, shard: Shard) -> Path:
    """Run what is missing of one shard of the episodes, without any results; :func:`run_experiment` makes them.

    Args:
        plan: the protocol.
        rows: of the table; all shards need the same checkpoints.
        output: where the results go; a shard keeps to a folder of its own in it, so that shards on several machines
            may share it.
        shard: which.

    Returns:
        The shard's folder.

    Raises:
        MissingFileError: if no row has a checkpoint.
        LlakeyError: as in :func:`run_experiment`, or if there are more shards than episodes.
        RuntimeError: if an episode fails.
    """
    found = _found(rows)
    folder = shard_folder(output.folder, shard)
    trials_of(plan, found.rows, shard)
    with alone_in(folder):
        claim(folder, settings_of(plan, rows, found.missing))
        run_missing(plan, found.rows, Records(folder / EPISODES), output.num_workers, output.engine, shard)
    return folder


def _found(rows: Sequence[Row]) -> Runnable:
    """The rows that can be run; the others are named."""
    found = runnable(rows)
    for row, reason in found.missing.items():
        print(f"skipped: {row} ({reason})")
    return found


def foresee(plan: Plan, rows: Sequence[Row], output: Output, shard: Shard = WHOLE) -> Estimate:
    """How many episodes are left and how long they take, without leaving anything in the folder.

    Raises:
        MissingFileError: if no row has a checkpoint.
    """
    folder = output.folder if shard == WHOLE else shard_folder(output.folder, shard)
    return estimate(plan, runnable(rows).rows, Records(folder / EPISODES), output.num_workers, output.engine, shard)


def report_table(
    plan: Plan, rows: Sequence[Row], records: Records, missing: Mapping[str, str], folder: Path
) -> tuple[dict[str, Any], str]:
    """Success by row and task: ``table.png``, and ``attribution.png`` where failures were put down to a level."""
    summary = summarise_table(plan, [row.name for row in rows], records)
    plots.plot_table(folder / "table.png", plan, rows, summary)
    plots.plot_attribution(folder / "attribution.png", plan, summary)
    figures = {"rows": summary, "paper": {"simulator": paper_results.SIMULATOR, "success": paper_results.SUCCESS}}
    return figures, markdown.table_page(plan, summary, missing)


def report_rollback(
    plan: Plan, rows: Sequence[Row], records: Records, missing: Mapping[str, str], folder: Path
) -> tuple[dict[str, Any], str]:
    """Recovery by row, event and task: ``rollback.png``."""
    summary = summarise_rollback(plan, [row.name for row in rows], records)
    plots.plot_rollback(folder / "rollback.png", summary)
    return {"rows": summary}, markdown.rollback_page(plan, summary, missing)
