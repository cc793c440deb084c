"""The tables in Markdown, with the protocol in words and the paper's own figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import fmean
from typing import Any

from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.records import ACTION, COMMAND
from lerobot_llakey.evaluation.protocol.summary import has_attribution
from lerobot_llakey.reporting import paper_results
from lerobot_llakey.reporting.tables import markdown_table

_NOTHING = "-"
PAPER_NOTE = (
    f"Rows marked *paper* are the paper's own figures, from {paper_results.SIMULATOR} and its own models of the tasks; "
    "here the tasks are re-made in MuJoCo, so they compare methods, not numbers."
)


def table_page(plan: Plan, summary: Mapping[str, Any], missing: Mapping[str, str]) -> str:
    """Success and attribution by row and task."""
    rows = [
        [row, *(_percent(cells["tasks"][task]) for task in plan.tasks), _percent(cells["average"])]
        for row, cells in summary.items()
    ]
    rows += paper_rows(paper_results.SUCCESS, plan.tasks)
    parts = [
        "# Success",
        f"{_protocol(plan)} {_statistics(plan)}",
        markdown_table(["row", *plan.tasks, "average"], rows),
        *_missing(missing),
        PAPER_NOTE,
    ]
    attributed = {row: cells["tasks"] for row, cells in summary.items() if has_attribution(cells["tasks"])}
    if attributed:
        parts += ["## Which level failed", _ATTRIBUTION_WORDS, _attribution_table(plan.tasks, attributed)]
    return "\n\n".join(parts) + "\n"


def rollback_page(plan: Plan, summary: Mapping[str, Any], missing: Mapping[str, str]) -> str:
    """Recovery by row, event and task."""
    rows = [
        [row, event, *(_recovered(cells["tasks"][task]) for task in plan.tasks), _recovered(cells["all"])]
        for row, events in summary.items()
        for event, cells in events.items()
    ]
    parts = [
        "# Recovery from unforeseen events",
        f"{_protocol(plan)} Given is how many of the episodes in which the event struck were solved all the same.",
        markdown_table(["row", "event", *plan.tasks, "all"], rows),
        *_missing(missing),
    ]
    attributed = {
        f"{row}, {event}": cells["tasks"]
        for row, events in summary.items()
        for event, cells in events.items()
        if has_attribution(cells["tasks"])
    }
    if attributed:
        parts += ["## Which level failed", _ATTRIBUTION_WORDS, _attribution_table(plan.tasks, attributed)]
    return "\n\n".join(parts) + "\n"


def paper_rows(figures: Mapping[str, Mapping[str, float]], tasks: Sequence[str]) -> list[list[str]]:
    """The paper's rows; an average only where all nine tasks are asked for."""
    complete = set(tasks) == set(paper_results.TASKS)
    return [
        [
            f"*paper: {name}*",
            *(f"{row[task]:g}" if task in row else _NOTHING for task in tasks),
            f"{fmean(row.values()):.1f}" if complete else _NOTHING,
        ]
        for name, row in figures.items()
    ]


_ATTRIBUTION_WORDS = (
    "Each failed episode was run again, the oracle's instruction taking the place of the first one that differed from "
    "it: where that was solved, the command was wrong, else the action. Given are command + action."
)


def _attribution_table(tasks: Sequence[str], attributed: Mapping[str, Mapping[str, Any]]) -> str:
    rows = [[row, *(_attribution(cells[task]["attribution"]) for task in tasks)] for row, cells in attributed.items()]
    return markdown_table(["row", *tasks], rows)


def _protocol(plan: Plan) -> str:
    return (
        f"{plan.num_episodes} episodes of each task, {plan.repeats} "
        f"{'repeat' if plan.repeats == 1 else 'repeats'} on other scenes, at most {plan.max_steps} actions an episode, "
        f"scenes of the {plan.split} split from {plan.first_seed}."
    )


def _statistics(plan: Plan) -> str:
    if plan.repeats < 3:
        return "Given is the mean of the repeats in percent ± their standard deviation."
    return (
        "Given is the mean of the repeats in percent, the best and the worst left out, ± the standard deviation of "
        "those that are left. The average is that of the columns, its spread that of the repeats' averages."
    )


def _missing(missing: Mapping[str, str]) -> list[str]:
    return [f"Not run: {'; '.join(f'{row} ({reason})' for row, reason in missing.items())}."] if missing else []


def _percent(cell: Mapping[str, Any]) -> str:
    return f"{100 * cell['success']:.1f} ± {100 * cell['spread']:.1f}"


def _recovered(cell: Mapping[str, Any]) -> str:
    if not cell["struck"]:
        return _NOTHING
    return f"{cell['recovered']}/{cell['struck']} ({100 * cell['rate']:.0f} %)"


def _attribution(attribution: Mapping[str, int]) -> str:
    return f"{attribution[COMMAND]} + {attribution[ACTION]}"
