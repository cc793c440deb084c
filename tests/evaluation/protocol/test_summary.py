"""Figures out of made-up episodes, worked out by hand."""

import pytest

from fakes_records import PLAN, made_up_records
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.records import ACTION, COMMAND
from lerobot_llakey.evaluation.protocol.summary import summarise_rollback, summarise_table


def test_success_is_trimmed_and_blame_is_counted() -> None:
    summary = summarise_table(PLAN, ["ours", "other"], reversed(made_up_records(PLAN)))
    drawer, jar = (summary["ours"]["tasks"][task] for task in PLAN.tasks)
    assert drawer["repeats"] == [0.0, 0.5, 1.0, 0.5] and drawer["success"] == 0.5 and drawer["spread"] == 0.0
    assert drawer["attribution"] == {COMMAND: 1, ACTION: 3} and drawer["solved"] == 4 and drawer["episodes"] == 8
    assert jar["success"] == 1.0 and jar["attribution"] == {COMMAND: 0, ACTION: 0}
    assert summary["ours"]["average"]["success"] == 0.75
    assert summary["other"]["tasks"]["open_drawer"]["attribution"] == {COMMAND: 0, ACTION: 0}


def test_recovery_counts_episodes_that_were_struck_alone() -> None:
    plan = Plan(PLAN.tasks, 2, 4, disturbances=("drop", "shift"))
    summary = summarise_rollback(plan, ["ours"], made_up_records(plan, disturbed=True))
    cell = summary["ours"]["shift"]["tasks"]["open_drawer"]
    assert (cell["episodes"], cell["struck"], cell["recovered"]) == (8, 6, 4)
    assert cell["rate"] == pytest.approx(4 / 6) and cell["interval"][0] < 4 / 6 < cell["interval"][1]
    assert cell["attribution"] == {COMMAND: 0, ACTION: 2}
    assert summary["ours"]["drop"]["all"]["struck"] == 12
    never = summarise_rollback(plan, ["ours"], made_up_records(plan))["ours"]["drop"]["all"]
    assert never["rate"] is None and never["struck"] == 0
