"""The paper's own figures: their averages are those that the paper gives in its text and its table."""

from statistics import fmean

import pytest

from lerobot_llakey.reporting import paper_results
from lerobot_llakey.sim.tasks import task_classes


def test_every_column_is_a_task_of_ours() -> None:
    assert sorted(paper_results.TASKS) == sorted(task_classes())
    for rows in (paper_results.SUCCESS, *paper_results.ABILITIES.values()):
        assert all(set(row) == set(paper_results.TASKS) for row in rows.values())


def test_llakey_is_15_5_points_ahead_of_rvt_as_the_paper_says() -> None:
    ours, theirs = (fmean(paper_results.SUCCESS[row].values()) for row in ("LLaKey 13B (3)", "RVT"))
    assert ours == pytest.approx(75.9, abs=0.05) and ours - theirs == pytest.approx(15.5, abs=0.2)


@pytest.mark.parametrize(
    ("ability", "row", "average"),
    [
        ("sequential_prediction", "LLaVA 13B (3)", 85.5),
        ("error_correction", "LLaVA 13B (3)", 85.3),
        ("sequential_prediction", "LLaVA 7B (3)", 84.5),
        ("error_correction", "LLaVA 7B (3)", 84.0),
        ("sequential_prediction", "LLaVA 13B (1)", 58.7),
        ("error_correction", "LLaVA 13B (1)", 60.9),
    ],
)
def test_averages_of_the_abilities(ability: str, row: str, average: float) -> None:
    assert fmean(paper_results.ABILITIES[ability][row].values()) == pytest.approx(
        average, abs=0.08
    )  # the paper cuts off digits
