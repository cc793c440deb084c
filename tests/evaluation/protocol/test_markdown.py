"""Summaries as pages for people."""

from fakes_records import PLAN, made_up_records
from lerobot_llakey.evaluation.protocol import markdown
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.summary import summarise_rollback, summarise_table
from lerobot_llakey.reporting import paper_results


def test_the_page_has_every_row_with_the_papers_beside() -> None:
    summary = summarise_table(PLAN, ["ours", "other"], made_up_records(PLAN))
    page = markdown.table_page(PLAN, summary, {"baseline": "no checkpoint at z"})
    lines = [[cell.strip() for cell in line.split("|")[1:-1]] for line in page.splitlines() if line.startswith("|")]
    assert ["ours", "50.0 ± 0.0", "100.0 ± 0.0", "75.0 ± 0.0"] in lines
    assert ["*paper: RVT*", "72", "42", "-"] in lines
    assert ["ours", "1 + 3", "0 + 0"] in lines and not any(line[:2] == ["other", "0 + 0"] for line in lines)
    assert "Not run: baseline (no checkpoint at z)." in page and "CoppeliaSim" in page


def test_the_papers_average_is_given_for_all_tasks_alone() -> None:
    assert markdown.paper_rows(paper_results.SUCCESS, paper_results.TASKS)[0][-1] == "75.9"
    assert markdown.paper_rows(paper_results.ABILITIES["error_correction"], paper_results.TASKS)[1][-1] == "85.3"


def test_the_page_of_recoveries() -> None:
    plan = Plan(PLAN.tasks, 2, 4, disturbances=("drop",))
    summary = summarise_rollback(plan, ["ours"], made_up_records(plan, disturbed=True))
    page = markdown.rollback_page(plan, summary, {})
    assert "4/6 (67 %)" in page and "10/12 (83 %)" in page and "ours, drop" in page
