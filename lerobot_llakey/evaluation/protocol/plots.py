"""The plots of a table: success with its spread, what failed, and recovery from events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.records import ACTION, COMMAND
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.evaluation.protocol.summary import has_attribution
from lerobot_llakey.reporting.paper_results import FROM_THE_PAPER, SUCCESS
from lerobot_llakey.reporting.plots import FONT, BarChart, canvas, finish, legend, save


def plot_table(path: Path, plan: Plan, rows: Sequence[Row], summary: Mapping[str, Any]) -> None:
    """Bars of success by task and row with the spread over repeats, and the paper's figures as diamonds."""
    chart = BarChart([*plan.tasks, "average"], len(summary), "success in %")
    papers = {row.name: SUCCESS.get(row.paper, {}) for row in rows}
    for row, cells in summary.items():
        figures = [*(cells["tasks"][task] for task in plan.tasks), cells["average"]]
        shares = [cell["success"] for cell in figures]
        bounds = [(share - cell["spread"], share + cell["spread"]) for share, cell in zip(shares, figures, strict=True)]
        for place, task in zip(chart.add(row, shares, bounds), plan.tasks, strict=False):
            if task in papers[row]:
                chart.mark(place, papers[row][task], FROM_THE_PAPER)
    chart.save(path)


def plot_attribution(path: Path, plan: Plan, summary: Mapping[str, Any]) -> bool:
    """For each row with two levels: the episodes of each task, solved, or failed by the command or the action.

    Returns:
        Whether there was anything to show.
    """
    shown = {row: cells["tasks"] for row, cells in summary.items() if has_attribution(cells["tasks"])}
    if not shown:
        return False
    figure = canvas(max(6.0, 1.2 * len(plan.tasks) + 2), 3.2 * len(shown) + 0.6)
    parts = (("solved", "#009E73", ""), ("the command was wrong", "#E69F00", "//"), ("the action was", "#D55E00", "xx"))
    for axes, (row, cells) in zip(figure.subplots(len(shown), 1, squeeze=False)[:, 0], shown.items(), strict=True):
        bottoms = [0.0] * len(plan.tasks)
        for (label, colour, hatch), key in zip(parts, ("solved", COMMAND, ACTION), strict=True):
            counts = [
                cells[task]["solved"] if key == "solved" else cells[task]["attribution"][key] for task in plan.tasks
            ]
            shares = [100 * n / cells[task]["episodes"] for n, task in zip(counts, plan.tasks, strict=True)]
            axes.bar(
                range(len(shares)), shares, 0.6, bottoms, color=colour, hatch=hatch, edgecolor="white", label=label
            )
            bottoms = [bottom + share for bottom, share in zip(bottoms, shares, strict=True)]
        axes.set_title(row, fontsize=FONT + 1)
        finish(axes, plan.tasks, "episodes in %")
    legend(figure, columns=3)
    save(figure, path)
    return True


def plot_rollback(path: Path, summary: Mapping[str, Any]) -> None:
    """Bars of the recovery from each event, all tasks together, by row, with 95 % intervals."""
    events = list(next(iter(summary.values())))
    chart = BarChart(events, len(summary), "solved all the same, in %")
    for row, cells in summary.items():
        figures = [cells[event]["all"] for event in events]
        bounds = [cell["interval"] if cell["struck"] else None for cell in figures]
        for place, cell in zip(chart.add(row, [cell["rate"] or 0.0 for cell in figures], bounds), figures, strict=True):
            chart.axes.annotate(
                str(cell["struck"]), (place, 1), ha="center", va="bottom", fontsize=FONT - 3, color="white"
            )
    chart.save(path)
