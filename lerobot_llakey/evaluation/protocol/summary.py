"""Figures of a table out of its episodes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from statistics import fmean
from typing import Any

from lerobot_llakey.evaluation.protocol.plan import UNDISTURBED, Plan
from lerobot_llakey.evaluation.protocol.records import ACTION, COMMAND, Record
from lerobot_llakey.reporting.statistics import kept, spread, trimmed_mean, wilson


def summarise_table(plan: Plan, rows: Sequence[str], records: Iterable[Record]) -> dict[str, Any]:
    """Success by row and task.

    Args:
        plan: the protocol.
        rows: names of the rows, all of whose episodes are done.
        records: of the episodes.

    Returns:
        For each row ``tasks``: for each task ``success`` (trimmed mean of the repeats' rates, in 0..1), ``spread``
        (their standard deviation), ``repeats`` (all rates), ``episodes``, ``solved``, ``actions`` (mean number),
        ``seconds`` (mean, with the attribution's run) and ``attribution`` (failures of each level). And ``average``:
        ``success``, the tasks' mean, and ``spread``, over the repeats' averages.
    """
    grouped = _by_cell(records)
    summary: dict[str, Any] = {}
    for row in rows:
        tasks = {task: _cell(plan, grouped[row, task, UNDISTURBED]) for task in plan.tasks}
        averages = [fmean(cell["repeats"][repeat] for cell in tasks.values()) for repeat in range(plan.repeats)]
        average = {"success": fmean(cell["success"] for cell in tasks.values()), "spread": spread(averages)}
        summary[row] = {"tasks": tasks, "average": average}
    return summary


def summarise_rollback(plan: Plan, rows: Sequence[str], records: Iterable[Record]) -> dict[str, Any]:
    """Recovery by row, event and task: success among the episodes in which the event struck.

    Returns:
        For each row and event ``tasks`` and ``all``: ``episodes``, ``struck``, ``recovered`` (of those), ``rate`` (None
        where it never struck), its 95 % ``interval`` after Wilson, and ``attribution``.
    """
    grouped = _by_cell(records)
    summary: dict[str, Any] = {}
    for row in rows:
        summary[row] = {}
        for event in plan.disturbances:
            cells = {task: grouped[row, task, event] for task in plan.tasks}
            every = [record for found in cells.values() for record in found]
            summary[row][event] = {
                "tasks": {task: _recovery(found) for task, found in cells.items()},
                "all": _recovery(every),
            }
    return summary


def has_attribution(cells: Mapping[str, Any]) -> bool:
    """Whether any failure of these tasks was put down to a level."""
    return any(sum(cell["attribution"].values()) for cell in cells.values())


def _by_cell(records: Iterable[Record]) -> dict[tuple[str, str, str], list[Record]]:
    grouped: dict[tuple[str, str, str], list[Record]] = {}
    for record in sorted(records, key=lambda record: record.trial.key):
        trial = record.trial
        grouped.setdefault((trial.row, trial.task, trial.disturbance), []).append(record)
    return grouped


def _cell(plan: Plan, records: Sequence[Record]) -> dict[str, Any]:
    by_repeat = [[record for record in records if record.trial.repeat == repeat] for repeat in range(plan.repeats)]
    rates = [fmean(record.episode.success for record in found) for found in by_repeat]
    return {
        "success": trimmed_mean(rates),
        "spread": spread(rates),
        "repeats": rates,
        "repeats_kept": len(kept(rates)),
        "episodes": len(records),
        "solved": sum(record.episode.success for record in records),
        "actions": fmean(len(record.episode.actions) for record in records),
        "seconds": fmean(record.seconds for record in records),
        "attribution": _attribution(records),
    }


def _recovery(records: Sequence[Record]) -> dict[str, Any]:
    struck = [record for record in records if record.episode.disturbed]
    recovered = sum(record.episode.success for record in struck)
    return {
        "episodes": len(records),
        "struck": len(struck),
        "recovered": recovered,
        "rate": recovered / len(struck) if struck else None,
        "interval": list(wilson(recovered, len(struck))),
        "seconds": fmean(record.seconds for record in records),
        "attribution": _attribution(struck),
    }


def _attribution(records: Sequence[Record]) -> dict[str, int]:
    return {level: sum(record.attribution == level for record in records) for level in (COMMAND, ACTION)}
