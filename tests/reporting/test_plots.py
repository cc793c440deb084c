"""Bars are as high as their shares and stand where marks are put beside them."""

from itertools import pairwise
from pathlib import Path

import pytest

from lerobot_llakey.reporting.plots import BarChart


def test_bars_stand_side_by_side_and_error_bars_stay_within_what_a_share_can_be(tmp_path: Path) -> None:
    chart = BarChart(["open_drawer", "average"], 2, "success in %")
    first = chart.add("ours", [0.5, 0.9], [(0.2, 0.7), (0.6, 1.2)])
    second = chart.add("other", [None, 0.25], [None, None])
    assert [bar.get_height() for bar in chart.axes.patches] == pytest.approx([50, 90, 25])
    edges = sorted((bar.get_x(), bar.get_x() + bar.get_width()) for bar in chart.axes.patches)
    assert all(before[1] < after[0] for before, after in pairwise(edges))
    assert first[0] < second[0] < 0.5 < first[1]
    spans = sorted(path.vertices[:, 1].tolist() for lines in chart.axes.collections for path in lines.get_paths())
    assert spans == [pytest.approx([20, 70]), pytest.approx([60, 100])]
    chart.save(tmp_path / "bars.png")
    assert (tmp_path / "bars.png").read_bytes()[:4] == b"\x89PNG"


def test_marks_of_a_kind_are_named_once() -> None:
    chart = BarChart(["a"], 1, "%")
    places = chart.add("ours", [0.5], [None])
    for percent in (40, 60):
        chart.mark(places[0], percent, "the paper's")
    assert chart.axes.get_legend_handles_labels()[1].count("the paper's") == 1
    assert [line.get_ydata()[0] for line in chart.axes.lines] == [40, 60]
