"""Figure 1 as a table and a plot, beside the paper's figures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from statistics import fmean
from typing import Any

from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.records import Record
from lerobot_llakey.experiments.arms import LLAKEY, Arm
from lerobot_llakey.experiments.wordings import BARE, PAPER, PUT, TAKE, TESTS, UNSCREW
from lerobot_llakey.reporting.paper_results import FROM_THE_PAPER, SIMULATOR
from lerobot_llakey.reporting.plots import BarChart
from lerobot_llakey.reporting.statistics import spread, trimmed_mean, wilson
from lerobot_llakey.reporting.tables import markdown_table
from lerobot_llakey.sim.tasks.put_bulb import LOOSE, SCREWED

_NOTHING = "-"
_SEQUENCES = {"loose": LOOSE, "screwed": SCREWED}


def summarise(plan: Plan, arms: Sequence[Arm], records: Iterable[Record]) -> list[dict[str, Any]]:
    """Figures of each arm.

    Returns:
        For each arm ``method``, ``training``, ``test``, ``success`` (trimmed mean of the repeats, in 0..1), ``spread``,
        ``interval`` (95 %, of all episodes), ``solved`` and ``episodes`` by sequence, and ``unscrewed``: the share of
        each sequence's episodes in which unscrewing was commanded, None where nobody commands.
    """
    found = list(records)
    return [_arm(plan, arm, [record for record in found if record.trial.row == arm.row.name]) for arm in arms]


def _arm(plan: Plan, arm: Arm, records: Sequence[Record]) -> dict[str, Any]:
    rates = [
        fmean(record.episode.success for record in records if record.trial.repeat == repeat)
        for repeat in range(plan.repeats)
    ]
    by_sequence = {
        name: [record.episode for record in records if record.episode.sequence == sequence]
        for name, sequence in _SEQUENCES.items()
    }
    solved = {name: sum(episode.success for episode in of) for name, of in by_sequence.items()}
    unscrewed = {
        name: fmean(any("screw" in said for said in episode.instructions) for episode in of) if of else None
        for name, of in by_sequence.items()
    }
    return {
        "method": arm.method,
        "training": arm.training,
        "test": arm.test,
        "success": trimmed_mean(rates),
        "spread": spread(rates),
        "interval": list(wilson(sum(solved.values()), len(records))),
        "solved": solved,
        "episodes": {name: len(of) for name, of in by_sequence.items()},
        "unscrewed": unscrewed if arm.method == LLAKEY else None,
    }


def ambiguity_page(plan: Plan, summary: Sequence[Mapping[str, Any]]) -> str:
    """The table in Markdown, with the wordings and what the figures say."""
    rows = [_row(cells) for cells in summary]
    header = ["policy", "trained with", "tested with", "success in %", "loose", "screwed", "unscrewing said", "paper"]
    parts = [
        "# Do the verbs matter?",
        f"`put_bulb`, {plan.num_episodes} episodes in {plan.repeats} "
        f"{'repeat' if plan.repeats == 1 else 'repeats'}, at most {plan.max_steps} actions, scenes of the {plan.split} "
        "split. One wording: every bulb is to be "
        f'"{PUT}". Two: those that are screwed in are to be named "{UNSCREW}". The other sequence\'s verbs: the other '
        f'one of these two, even where only one was trained. Replaced: "{TAKE}". Removed: "{BARE}".',
        markdown_table(header, rows),
        "Loose and screwed: episodes solved of each sequence. Unscrewing said: the share of loose, then of screwed "
        "bulbs for which the command policy said to screw; verbs lead where it follows the wording and not the bulb. "
        f"The paper's figures (section I) are of its own model in {SIMULATOR}, told the skill instruction, and "
        "stand beside our baseline.",
        "\n".join(f"- {line}" for line in findings(summary)),
    ]
    return "\n\n".join(parts) + "\n"


def findings(summary: Sequence[Mapping[str, Any]]) -> list[str]:
    """For each policy and training: by how much success changes from the wording as trained to each other one."""
    trained = {(cells["method"], cells["training"]): cells for cells in summary if cells["test"] == "as_trained"}
    lines = []
    for cells in summary:
        before = trained.get((cells["method"], cells["training"]))
        if before is None or cells is before:
            continue
        change = 100 * (cells["success"] - before["success"])
        apart = cells["interval"][0] > before["interval"][1] or cells["interval"][1] < before["interval"][0]
        meaning = "" if apart else "; the 95 % intervals overlap"
        lines.append(
            f"{cells['method']}, {_wordings(cells)}: {change:+.0f} points with {TESTS[cells['test']]}{meaning}."
        )
    return lines


def plot_ambiguity(path: Path, summary: Sequence[Mapping[str, Any]]) -> None:
    """Bars of success by policy and training, one colour a test, with 95 % intervals and the paper's as diamonds."""
    groups = list(dict.fromkeys(_key(cells)[:2] for cells in summary))
    names = [f"{method}\n{_wordings({'training': training})}" for method, training in groups]
    by_key = {_key(cells): cells for cells in summary}
    tests = list(dict.fromkeys(cells["test"] for cells in summary))
    chart = BarChart(names, len(tests), "success in %")
    for test in tests:
        found = [by_key.get((*group, test)) for group in groups]
        shares = [None if cells is None else cells["success"] for cells in found]
        bounds = [None if cells is None else cells["interval"] for cells in found]
        for place, cells in zip(chart.add(TESTS[test], shares, bounds), found, strict=True):
            if cells is not None and (value := _papers(cells)) is not None:
                chart.mark(place, value, FROM_THE_PAPER)
    chart.save(path)


def _row(cells: Mapping[str, Any]) -> list[str]:
    said, value = cells["unscrewed"], _papers(cells)
    counts = [f"{cells['solved'][name]}/{cells['episodes'][name]}" for name in _SEQUENCES]
    shares = [_NOTHING if said is None or said[name] is None else f"{100 * said[name]:.0f} %" for name in _SEQUENCES]
    return [
        cells["method"],
        _wordings(cells),
        TESTS[cells["test"]],
        f"{100 * cells['success']:.1f} ± {100 * cells['spread']:.1f}",
        *counts,
        _NOTHING if said is None else " / ".join(shares),
        _NOTHING if value is None else f"{value:g}",
    ]


def _papers(cells: Mapping[str, Any]) -> float | None:
    """The paper's figure, which is of a policy told the skill instruction: our baseline."""
    return None if cells["method"] == LLAKEY else PAPER.get((cells["training"], cells["test"]))


def _wordings(cells: Mapping[str, Any]) -> str:
    return "one wording" if cells["training"] == "one" else "two wordings"


def _key(cells: Mapping[str, Any]) -> tuple[str, str, str]:
    return cells["method"], cells["training"], cells["test"]
