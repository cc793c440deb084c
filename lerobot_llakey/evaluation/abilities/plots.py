"""The abilities as pictures: bars by task, and which verb was taken for which."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lerobot_llakey.evaluation.abilities.measure import ABILITIES, Measured
from lerobot_llakey.evaluation.abilities.report import PAPER_ROWS, title, verbs_of
from lerobot_llakey.evaluation.abilities.score import Score, macro
from lerobot_llakey.reporting import paper_results
from lerobot_llakey.reporting.plots import BarChart, canvas, save
from lerobot_llakey.reporting.statistics import wilson

_MARKS = ("D", "o")


def plot_abilities(measured: Measured, path: Path) -> None:
    """Bars of both abilities by task with 95 % intervals, their average over tasks, and the paper's as open marks."""
    tasks = sorted({task for scores in measured.tasks.values() for task in scores})
    chart = BarChart([*tasks, "average"], len(ABILITIES), "right answers in %")
    for ability in ABILITIES:
        scores = [measured.tasks[ability].get(task, Score()) for task in tasks]
        shares = [*(score.share("exact") for score in scores), macro(scores)["exact"]]
        places = chart.add(title(ability), shares, [*(wilson(score.exact, score.samples) for score in scores), None])
        for row, marker in zip(PAPER_ROWS, _MARKS, strict=True):
            figures = paper_results.ABILITIES[ability][row]
            found = {**figures, "average": sum(figures.values()) / len(figures)}
            for place, column in zip(places, [*tasks, "average"], strict=True):
                if column in found:
                    chart.mark(place, found[column], f"the paper's {row}, from {paper_results.SIMULATOR}", marker)
    chart.save(path)


def plot_verbs(measured: Measured, path: Path) -> None:
    """Matrices of the verb expected (row) and answered (column): counts, and shares of a row as colour."""
    whole = sum((measured.total(ability) for ability in ABILITIES), Score())
    verbs = verbs_of(whole)
    size = 1.5 + 0.48 * len(verbs)
    figure = canvas(2 * size + 1.5, size + 1.0)
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
    save(figure, path)


def verb_matrix(score: Score, verbs: list[str]) -> np.ndarray:
    """Counts (V, V) of the verb expected (row) and answered (column)."""
    counts = np.zeros((len(verbs), len(verbs)), dtype=int)
    for (expected, answered), count in score.verbs.items():
        counts[verbs.index(expected), verbs.index(answered)] = count
    return counts
