"""Summaries as plots."""

from pathlib import Path

import cv2

from fakes_records import PLAN, ROWS, made_up_records
from lerobot_llakey.evaluation.protocol import plots
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.summary import summarise_rollback, summarise_table


def test_plots_are_drawn(tmp_path: Path) -> None:
    summary = summarise_table(PLAN, ["ours", "other"], made_up_records(PLAN))
    plots.plot_table(tmp_path / "table.png", PLAN, ROWS, summary)
    assert plots.plot_attribution(tmp_path / "attribution.png", PLAN, summary)
    assert not plots.plot_attribution(tmp_path / "none.png", PLAN, {"other": summary["other"]})
    plan = Plan(PLAN.tasks, 2, 4, disturbances=("drop", "shift"))
    plots.plot_rollback(
        tmp_path / "rollback.png", summarise_rollback(plan, ["ours", "other"], made_up_records(plan, True))
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == ["attribution.png", "rollback.png", "table.png"]
    for path in tmp_path.iterdir():
        picture = cv2.imread(str(path))
        assert picture is not None and min(picture.shape[:2]) > 300
        blue = (abs(picture.astype(int) - (0xB2, 0x72, 0x00)).sum(-1) < 30).sum()  # BGR of the first row's bars
        assert path.name == "attribution.png" or blue > 1000
