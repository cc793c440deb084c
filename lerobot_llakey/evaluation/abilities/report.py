"""The abilities as tables: Markdown for people, CSV for programs."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from lerobot_llakey.evaluation.abilities.measure import ABILITIES, Measured
from lerobot_llakey.evaluation.abilities.remaining_distance import REMAINING_DISTANCES
from lerobot_llakey.evaluation.abilities.score import MEASURES, OUTSIDE, Score, macro
from lerobot_llakey.evaluation.abilities.situation import SITUATIONS
from lerobot_llakey.files import replacing, write_whole
from lerobot_llakey.reporting import paper_results
from lerobot_llakey.reporting.statistics import wilson
from lerobot_llakey.reporting.tables import markdown_table

PAPER_ROWS = ("LLaVA 13B (3)", "LLaVA 7B (3)")
"""Rows of the paper's table I that stand beside a measurement."""
_PAPERS = [f"paper, {row.removeprefix('LLaVA ').removesuffix(' (3)')}" for row in PAPER_ROWS]


def title(name: str) -> str:
    """A name as it is read."""
    return name.replace("_", " ")


def markdown(measured: Measured) -> str:
    """Both abilities by task, beside the paper's figures, those after events, and the commonest mistakes."""
    blocks = [f"# Abilities of the command policy\n\nThe paper's figures are from {paper_results.SIMULATOR}."]
    for ability in ABILITIES:
        blocks.append(f"## {title(ability)}\n\n{ability_table(measured, ability)}")
    if measured.left:
        table = _parts_table("way left", REMAINING_DISTANCES, measured.left)
        blocks.append(f"## Error correction by the way that the hand still had to go\n\n{table}")
    if measured.situations:
        table = _parts_table("the robot is", SITUATIONS, measured.situations)
        blocks.append(f"## All frames by what the robot was doing\n\n{table}")
    if any(measured.events.values()):
        blocks.append(f"## After unforeseen events\n\n{event_table(measured)}")
    for ability in ABILITIES:
        mistakes = mistake_table(measured.total(ability))
        if mistakes:
            blocks.append(f"## Commonest mistakes: {title(ability)}\n\n{mistakes}")
    return "\n\n".join(blocks) + "\n"


def ability_table(measured: Measured, ability: str) -> str:
    """One ability: a row a task, their average, and all samples; shares in %."""
    scores, total = measured.tasks[ability], measured.total(ability)
    rows = [[task, *_cells(scores[task]), *_papers(ability, task)] for task in sorted(scores)]
    average = macro(list(scores.values()))
    averages = [f"{100 * average[name]:.1f}" for name in MEASURES]
    rows.append(["average over tasks", str(average["samples"]), averages[0], "", *averages[1:], "", *_papers(ability)])
    rows.append(["all samples", *_cells(total), *[""] * len(_PAPERS)])
    return markdown_table(["task", "samples", "exact", "95 %", "verb", "objects", "unparsable", *_PAPERS], rows)


def event_table(measured: Measured) -> str:
    """Both abilities on the frames after each event; shares in %."""
    rows = [
        [event, title(ability), *_cells(measured.events[ability][event])]
        for event in sorted({name for scores in measured.events.values() for name in scores})
        for ability in ABILITIES
        if event in measured.events[ability]
    ]
    return markdown_table(["event", "ability", "samples", "exact", "95 %", "verb", "objects", "unparsable"], rows)


def _parts_table(head: str, names: Sequence[str], scores: Mapping[str, Score]) -> str:
    """A row for each part of the answers that there is; shares in %."""
    rows = [[name, *_cells(scores[name])] for name in names if name in scores]
    return markdown_table([head, "samples", "exact", "95 %", "verb", "objects", "unparsable"], rows)


def mistake_table(score: Score, count: int = 10) -> str:
    """The commonest wrong answers; "" where there are none."""
    worst = sorted(score.confusions.items(), key=lambda item: (-item[1], item[0]))[:count]
    rows = [[str(times), expected, answer] for (expected, answer), times in worst]
    return markdown_table(["times", "expected", "answered"], rows) if rows else ""


def verbs_of(score: Score) -> list[str]:
    """The templates that were expected or answered, sorted; what is outside the grammar last."""
    found = {verb for pair in score.verbs for verb in pair}
    return sorted(found - {OUTSIDE}) + [OUTSIDE] * (OUTSIDE in found)


def write_tables(measured: Measured, folder: Path) -> list[Path]:
    """Write ``abilities.md``, ``confusions.csv`` (instructions, wrong answers only) and ``verbs.csv`` (all answers)."""
    report = folder / "abilities.md"
    write_whole(report, markdown(measured))
    instructions = [
        (ability, task, *pair, count)
        for ability in ABILITIES
        for task, score in sorted(measured.tasks[ability].items())
        for pair, count in score.confusions.most_common()
    ]
    header = ("ability", "task", "expected", "answered", "count")
    _write_csv(folder / "confusions.csv", header, instructions)
    _write_csv(folder / "verbs.csv", ("ability", "expected", "answered", "count"), _verb_rows(measured))
    return [report, folder / "confusions.csv", folder / "verbs.csv"]


def _verb_rows(measured: Measured) -> Iterator[tuple[str, str, str, int]]:
    for ability in ABILITIES:
        for (expected, answered), count in sorted(measured.total(ability).verbs.items()):
            yield ability, expected, answered, count


def _write_csv(path: Path, header: Sequence[str], rows: Iterator[tuple] | Sequence[tuple]) -> None:
    with replacing(path) as fresh, fresh.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)


def _cells(score: Score) -> list[str]:
    low, high = wilson(score.exact, score.samples)
    exact, *others = (f"{100 * score.share(name):.1f}" for name in (*MEASURES, "unparsable"))
    return [str(score.samples), exact, f"{100 * low:.0f} to {100 * high:.0f}", *others]


def _papers(ability: str, task: str | None = None) -> list[str]:
    """The paper's figures for a task, or its averages; "" for tasks that it does not have."""
    found = [paper_results.ABILITIES[ability][row] for row in PAPER_ROWS]
    if task is None:
        return [f"{sum(figures.values()) / len(figures):.1f}" for figures in found]
    return [f"{figures[task]:.1f}" if task in figures else "" for figures in found]
