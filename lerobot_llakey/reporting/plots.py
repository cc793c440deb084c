"""What all plots have in common: a canvas, bars in groups with their intervals, and files that appear whole."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from lerobot_llakey.files import replacing

COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442", "#7F7F7F")
"""Okabe and Ito's colours, which people with any colour vision tell apart."""
FONT = 12
_HATCHES = ("", "//", "..", "xx", "\\\\", "oo", "--", "++")
_GROUP, _HEIGHT, _DPI = 0.84, 4.6, 110


def canvas(width: float, height: float = _HEIGHT) -> Figure:
    """An empty figure of so many inches."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def finish(axes: Axes, columns: Sequence[str], unit: str) -> None:
    """Name the columns at 0, 1, ... and the height, which is in percent."""
    axes.set_xticks(range(len(columns)), [_broken(name) for name in columns], fontsize=FONT)
    axes.set_xlim(-0.6, len(columns) - 0.4)
    axes.set_ylim(0, 108)
    axes.set_yticks(range(0, 101, 20))
    axes.set_ylabel(unit, fontsize=FONT)
    axes.tick_params(axis="y", labelsize=FONT - 1)
    axes.grid(axis="y", color="#d0d0d0", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def legend(figure: Figure, columns: int = 2) -> None:
    """What the first axes show, below them."""
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, fontsize=FONT - 1, frameon=False)


def save(figure: Figure, path: Path) -> None:
    """Write a PNG, whole or not at all."""
    with replacing(path) as unfinished:
        figure.savefig(unfinished, dpi=_DPI, format="png")


class BarChart:
    """Shares in groups of bars, one group a column and one bar a series.

    Args:
        columns: names of the groups.
        series: how many bars a group has.
        unit: of the heights, which are in percent.
        width: of a bar in inches, with its share of the space between groups.
    """

    def __init__(self, columns: Sequence[str], series: int, unit: str, width: float = 0.4) -> None:
        self.figure = canvas(max(7.0, len(columns) * max(1.6, width * series + 0.75)))
        self.axes = self.figure.subplots()
        self._width, self._drawn = _GROUP / series, 0
        self._labels: set[str] = set()
        finish(self.axes, columns, unit)

    def add(
        self, label: str, shares: Sequence[float | None], bounds: Sequence[tuple[float, float] | None]
    ) -> list[float]:
        """Draw the bars of the next series.

        Args:
            label: its name.
            shares: of each group in 0..1; no bar where None.
            bounds: of each share; no error bar where None.

        Returns:
            Where the bars stand, those left out too.
        """
        index, self._drawn = self._drawn, self._drawn + 1
        places = [column + (index + 0.5) * self._width - _GROUP / 2 for column in range(len(shares))]
        self.axes.bar(
            [place for place, share in zip(places, shares, strict=True) if share is not None],
            [100 * share for share in shares if share is not None],
            0.94 * self._width,
            color=COLOURS[index % len(COLOURS)],
            hatch=_HATCHES[index % len(_HATCHES)],
            edgecolor="white",
            label=label,
        )
        for place, share, edges in zip(places, shares, bounds, strict=True):
            if share is not None and edges is not None:
                low, high = max(0.0, share - max(0.0, edges[0])), max(0.0, min(1.0, edges[1]) - share)
                around = [[100 * low], [100 * high]]
                self.axes.errorbar(
                    [place], [100 * share], around, fmt="none", ecolor="black", elinewidth=1.4, capsize=3
                )
        return places

    def mark(self, place: float, percent: float, label: str, marker: str = "D") -> None:
        """A figure from elsewhere beside a bar; marks of one label are alike, and named once."""
        shown = None if label in self._labels else label
        self._labels.add(label)
        self.axes.plot([place], [percent], marker, color="white", markeredgecolor="black", label=shown)

    def save(self, path: Path) -> None:
        """Write it with its legend."""
        legend(self.figure)
        save(self.figure, path)


def _broken(name: str) -> str:
    """A name in lines short enough to stand beside others."""
    lines = [""]
    for word in name.split("_"):
        if lines[-1] and len(lines[-1]) + len(word) > 10:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return "\n".join(lines)
