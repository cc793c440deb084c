"""The abilities as pictures: bars by task, and which verb was taken for which."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from lerobot_llakey.evaluation.abilities.measure import ABILITIES, Measured
from lerobot_llakey.evaluation.abilities.report import PAPER_ROWS, title, verbs_of
from lerobot_llakey.evaluation.abilities.score import Score, macro
from lerobot_llakey.files import replacing
from lerobot_llakey.reporting import paper_results
from lerobot_llakey.reporting.statistics import wilson

_COLOURS = ("#0072B2", "#E69F00")
_MARKS = ("D", "o")
_WIDTH, _DPI = 0.38, 110


def plot_abilities(measured: Measured, path: Path) -> None:
    """Bars of both abilities by task with 95 % intervals, their average over tasks, and the paper's as open marks."""
    tasks = sorted({task for scores in measured.tasks.values() for task in scores})
    columns = [*tasks, "average"]
    figure = Figure(figsize=(max(7.0, 1.15 * len(columns) + 1.5), 5.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for index, ability in enumerate(ABILITIES):
        scores = [measured.tasks[ability].get(task, Score()) for task in tasks]
        heights = [*(100 * score.share("exact") for score in scores), 100 * macro(scores)["exact"]]
        places = np.arange(len(columns)) + (index - 0.5) * _WIDTH
        axes.bar(places, heights, 0.94 * _WIDTH, color=_COLOURS[index], label=title(ability))
        bounds = 100 * np.array([wilson(score.exact, score.samples) for score in scores]).reshape(-1, 2)
        around = np.abs(bounds.T - np.array(heights[:-1]))
        axes.errorbar(places[:-1], heights[:-1], around, fmt="none", ecolor="black", elinewidth=1.2, capsize=3)
        for row, mark in zip(PAPER_ROWS, _MARKS, strict=True):
            figures = paper_results.ABILITIES[ability][row]
            values = [*(figures.get(task, np.nan) for task in tasks), sum(figures.values()) / len(figures)]
            label = f"the paper's {row}, from {paper_results.SIMULATOR}" if index == 0 else None
            axes.plot(places, values, mark, color="white", markeredgecolor="black", markersize=5, label=label)
    axes.set_xticks(range(len(columns)), [name.replace("_", "\n") for name in columns], fontsize=9)
    axes.set_ylim(0, 105)
    axes.set_ylabel("right answers in %")
    axes.grid(axis="y", color="#d0d0d0", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    figure.legend(loc="outside lower center", ncols=2, frameon=False)
    with replacing(path) as fresh:
        figure.savefig(fresh, dpi=_DPI, format="png")


def plot_verbs(measured: Measured, path: Path) -> None:
    """Matrices of the verb expected (row) and answered (column): counts, and shares of a row as colour."""
    whole = sum((measured.total(ability) for ability in ABILITIES), Score())
    verbs = verbs_of(whole)
    size = 1.5 + 0.48 * len(verbs)
    figure = Figure(figsize=(2 * size + 1.5, size + 1.0), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, ability in zip(figure.subplots(1, len(ABILITIES)), ABILITIES, strict=True):
        counts = verb_matrix(measured.total(ability), verbs)
        shares = counts / np.maximum(1, counts.sum(axis=1, keepdims=True))
        axes.imshow(shares, cmap="Blues", vmin=0, vmax=1)
        for row, column in np.argwhere(counts):
            colour = "white" if shares[row, column] > 0.6 else "black"
            text = str(counts[row, column])
            axes.text(column, row, text, ha="center", va="center", fontsize=8, color=colour)
        axes.set_xticks(range(len(verbs)), [title(verb) for verb in verbs], rotation=60, ha="right", fontsize=8)
        axes.set_yticks(range(len(verbs)), [title(verb) for verb in verbs], fontsize=8)
        axes.set_xlabel("answered")
        axes.set_ylabel("expected")
        axes.set_title(title(ability))
    with replacing(path) as fresh:
        figure.savefig(fresh, dpi=_DPI, format="png")


def verb_matrix(score: Score, verbs: list[str]) -> np.ndarray:
    """Counts (V, V) of the verb expected (row) and answered (column)."""
    counts = np.zeros((len(verbs), len(verbs)), dtype=int)
    for (expected, answered), count in score.verbs.items():
        counts[verbs.index(expected), verbs.index(answered)] = count
    return counts
