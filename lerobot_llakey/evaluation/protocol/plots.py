"""The plots of a table: success with its spread, what failed, and recovery from events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.records import ACTION, COMMAND
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.evaluation.protocol.summary import has_blame
from lerobot_llakey.files import replacing
from lerobot_llakey.reporting import paper_results

COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442", "#7F7F7F")
"""Okabe and Ito's colours, which people with any colour vision tell apart."""
_HATCHES = ("", "//", "..", "xx", "\\\\", "oo", "--", "++")
_GROUP, _HEIGHT, _DPI, _FONT = 0.84, 4.6, 110, 12


def plot_table(path: Path, plan: Plan, rows: Sequence[Row], summary: Mapping[str, Any]) -> None:
    """Bars of success by task and row with the spread over repeats, and the paper's figures as diamonds."""
    columns = [*plan.tasks, "average"]
    figure, axes = _figure(len(columns) * max(1.6, 0.4 * len(summary) + 0.7))
    width = _GROUP / len(summary)
    papers = {row.name: paper_results.SUCCESS.get(row.paper, {}) for row in rows}
    marked = False
    for index, (row, cells) in enumerate(summary.items()):
        figures = [*(cells["tasks"][task] for task in plan.tasks), cells["average"]]
        places = [column + (index + 0.5) * width - _GROUP / 2 for column in range(len(columns))]
        heights = [100 * cell["success"] for cell in figures]
        spreads = [100 * cell["spread"] for cell in figures]
        _bars(axes, places, heights, _within(heights, spreads), width, index, row)
        for place, task in zip(places, plan.tasks, strict=False):
            if task in papers[row]:
                label = None if marked else f"the paper's, from {paper_results.SIMULATOR}"
                axes.plot([place], [papers[row][task]], "D", color="white", markeredgecolor="black", label=label)
                marked = True
    _finish(axes, columns, "success in %")
    _legend(figure)
    _save(figure, path)


def plot_blame(path: Path, plan: Plan, summary: Mapping[str, Any]) -> bool:
    """For each row with two levels: the episodes of each task, solved, or failed by the command or the action.

    Returns:
        Whether there was anything to show.
    """
    shown = {row: cells["tasks"] for row, cells in summary.items() if has_blame(cells["tasks"])}
    if not shown:
        return False
    figure = Figure(figsize=(max(6.0, 1.2 * len(plan.tasks) + 2), 3.2 * len(shown) + 0.6), layout="constrained")
    parts = (("solved", "#009E73", ""), ("the command was wrong", "#E69F00", "//"), ("the action was", "#D55E00", "xx"))
    for axes, (row, cells) in zip(figure.subplots(len(shown), 1, squeeze=False)[:, 0], shown.items(), strict=True):
        bottoms = [0.0] * len(plan.tasks)
        for (label, colour, hatch), key in zip(parts, ("solved", COMMAND, ACTION), strict=True):
            counts = [cells[task]["solved"] if key == "solved" else cells[task]["blame"][key] for task in plan.tasks]
            shares = [100 * n / cells[task]["episodes"] for n, task in zip(counts, plan.tasks, strict=True)]
            axes.bar(
                range(len(shares)), shares, 0.6, bottoms, color=colour, hatch=hatch, edgecolor="white", label=label
            )
            bottoms = [bottom + share for bottom, share in zip(bottoms, shares, strict=True)]
        axes.set_title(row, fontsize=_FONT + 1)
        _finish(axes, plan.tasks, "episodes in %")
    _legend(figure, columns=3)
    _save(figure, path)
    return True


def plot_rollback(path: Path, summary: Mapping[str, Any]) -> None:
    """Bars of the recovery from each event, all tasks together, by row, with 95 % intervals."""
    events = list(next(iter(summary.values())))
    figure, axes = _figure(len(events) * max(1.8, 0.4 * len(summary) + 0.8))
    width = _GROUP / len(summary)
    for index, (row, cells) in enumerate(summary.items()):
        figures = [cells[event]["all"] for event in events]
        places = [place + (index + 0.5) * width - _GROUP / 2 for place in range(len(events))]
        heights = [100 * (cell["rate"] or 0.0) for cell in figures]
        intervals = [cell["interval"] if cell["struck"] else (0.0, 0.0) for cell in figures]
        low = [max(0.0, height - 100 * bounds[0]) for height, bounds in zip(heights, intervals, strict=True)]
        high = [max(0.0, 100 * bounds[1] - height) for height, bounds in zip(heights, intervals, strict=True)]
        _bars(axes, places, heights, [low, high], width, index, row)
        for place, cell in zip(places, figures, strict=True):
            axes.annotate(str(cell["struck"]), (place, 1), ha="center", va="bottom", fontsize=_FONT - 3, color="white")
    _finish(axes, events, "solved all the same, in %")
    _legend(figure)
    _save(figure, path)


def _figure(width: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(max(7.0, width), _HEIGHT), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots()


def _bars(
    axes: Axes,
    places: Sequence[float],
    heights: Sequence[float],
    errors: Sequence[Sequence[float]],
    width: float,
    index: int,
    label: str,
) -> None:
    axes.bar(
        places,
        heights,
        0.94 * width,
        color=COLOURS[index % len(COLOURS)],
        hatch=_HATCHES[index % len(_HATCHES)],
        edgecolor="white",
        label=label,
    )
    axes.errorbar(places, heights, errors, fmt="none", ecolor="black", elinewidth=1.4, capsize=3)


def _finish(axes: Axes, columns: Sequence[str], unit: str) -> None:
    axes.set_xticks(range(len(columns)), [_broken(name) for name in columns], fontsize=_FONT)
    axes.set_xlim(-0.6, len(columns) - 0.4)
    axes.set_ylim(0, 108)
    axes.set_yticks(range(0, 101, 20))
    axes.set_ylabel(unit, fontsize=_FONT)
    axes.tick_params(axis="y", labelsize=_FONT - 1)
    axes.grid(axis="y", color="#d0d0d0", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _legend(figure: Figure, columns: int = 2) -> None:
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, fontsize=_FONT - 1, frameon=False)


def _within(heights: Sequence[float], spreads: Sequence[float]) -> list[list[float]]:
    """Lengths of error bars below and above, no further than a share can go."""
    pairs = list(zip(heights, spreads, strict=True))
    return [[min(spread, height) for height, spread in pairs], [min(spread, 100 - height) for height, spread in pairs]]


def _broken(name: str) -> str:
    """A name in lines short enough to stand beside others."""
    lines = [""]
    for word in name.split("_"):
        if lines[-1] and len(lines[-1]) + len(word) > 10:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return "\n".join(lines)


def _save(figure: Figure, path: Path) -> None:
    with replacing(path) as unfinished:
        figure.savefig(unfinished, dpi=_DPI, format="png")
