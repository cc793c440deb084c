"""Figures out of made-up episodes, worked out by hand; then as a page and as plots."""

from pathlib import Path

import cv2
import pytest

from lerobot_llakey.evaluation.protocol import markdown, paper, plots
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.records import ACTION, COMMAND, Record
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.evaluation.protocol.summary import summarise_rollback, summarise_table
from lerobot_llakey.evaluation.rollout import Episode

ROWS = [Row("ours", "x", paper="LLaKey 13B (3)"), Row("other", "y")]
PLAN = Plan(("open_drawer", "close_jar"), num_episodes=2, repeats=4)
SOLVED = {"open_drawer": (0, 1, 2, 1), "close_jar": (2, 2, 2, 2)}
"""How many of the two episodes of each repeat are solved."""


def _records(plan: Plan, disturbed: bool = False) -> list[Record]:
    records = []
    for trial in plan.trials(ROWS):
        success = trial.episode < SOLVED[trial.task][trial.repeat]
        struck = disturbed and trial.repeat > 0
        episode = Episode(
            trial.task, "", trial.scene, 0, 0, success, ["a"] * 3, [""] * 3, ["a"] * 3, [[0.0]] * 3, struck
        )
        blame = "" if success or trial.row == "other" else (COMMAND, ACTION)[trial.episode]
        records.append(Record(trial, episode, blame, None, 2.0))
    return records


def test_success_is_trimmed_and_blame_is_counted() -> None:
    summary = summarise_table(PLAN, ["ours", "other"], reversed(_records(PLAN)))
    drawer, jar = (summary["ours"]["tasks"][task] for task in PLAN.tasks)
    assert drawer["repeats"] == [0.0, 0.5, 1.0, 0.5] and drawer["success"] == 0.5 and drawer["spread"] == 0.0
    assert drawer["blame"] == {COMMAND: 1, ACTION: 3} and drawer["solved"] == 4 and drawer["episodes"] == 8
    assert jar["success"] == 1.0 and jar["blame"] == {COMMAND: 0, ACTION: 0}
    assert summary["ours"]["average"]["success"] == 0.75
    assert summary["other"]["tasks"]["open_drawer"]["blame"] == {COMMAND: 0, ACTION: 0}


def test_recovery_counts_episodes_that_were_struck_alone() -> None:
    plan = Plan(PLAN.tasks, 2, 4, disturbances=("drop", "shift"))
    summary = summarise_rollback(plan, ["ours"], _records(plan, disturbed=True))
    cell = summary["ours"]["shift"]["tasks"]["open_drawer"]
    assert (cell["episodes"], cell["struck"], cell["recovered"]) == (8, 6, 4)
    assert cell["rate"] == pytest.approx(4 / 6) and cell["interval"][0] < 4 / 6 < cell["interval"][1]
    assert cell["blame"] == {COMMAND: 0, ACTION: 2}
    assert summary["ours"]["drop"]["all"]["struck"] == 12
    never = summarise_rollback(plan, ["ours"], _records(plan))["ours"]["drop"]["all"]
    assert never["rate"] is None and never["struck"] == 0


def test_the_page_has_every_row_with_the_papers_beside() -> None:
    summary = summarise_table(PLAN, ["ours", "other"], _records(PLAN))
    page = markdown.table_page(PLAN, summary, {"baseline": "no checkpoint at z"})
    lines = [[cell.strip() for cell in line.split("|")[1:-1]] for line in page.splitlines() if line.startswith("|")]
    assert ["ours", "50.0 ± 0.0", "100.0 ± 0.0", "75.0 ± 0.0"] in lines
    assert ["*paper: RVT*", "72", "42", "-"] in lines
    assert ["ours", "1 + 3", "0 + 0"] in lines and not any(line[:2] == ["other", "0 + 0"] for line in lines)
    assert "Not run: baseline (no checkpoint at z)." in page and "CoppeliaSim" in page


def test_the_papers_average_is_given_for_all_tasks_alone() -> None:
    assert markdown.paper_rows(paper.SUCCESS, paper.TASKS)[0][-1] == "75.9"
    assert markdown.paper_rows(paper.ABILITIES["error_correction"], paper.TASKS)[1][-1] == "85.3"


def test_the_page_of_recoveries() -> None:
    plan = Plan(PLAN.tasks, 2, 4, disturbances=("drop",))
    summary = summarise_rollback(plan, ["ours"], _records(plan, disturbed=True))
    page = markdown.rollback_page(plan, summary, {})
    assert "4/6 (67 %)" in page and "10/12 (83 %)" in page and "ours, drop" in page


def test_plots_are_drawn(tmp_path: Path) -> None:
    summary = summarise_table(PLAN, ["ours", "other"], _records(PLAN))
    plots.plot_table(tmp_path / "table.png", PLAN, ROWS, summary)
    assert plots.plot_blame(tmp_path / "blame.png", PLAN, summary)
    assert not plots.plot_blame(tmp_path / "none.png", PLAN, {"other": summary["other"]})
    plan = Plan(PLAN.tasks, 2, 4, disturbances=("drop", "shift"))
    plots.plot_rollback(tmp_path / "rollback.png", summarise_rollback(plan, ["ours", "other"], _records(plan, True)))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["blame.png", "rollback.png", "table.png"]
    for path in tmp_path.iterdir():
        picture = cv2.imread(str(path))
        assert picture is not None and min(picture.shape[:2]) > 300
        blue = (abs(picture.astype(int) - (0xB2, 0x72, 0x00)).sum(-1) < 30).sum()  # BGR of the first row's bars
        assert path.name == "blame.png" or blue > 1000
