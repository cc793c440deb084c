import csv
from pathlib import Path

import pytest

from lerobot_llakey.evaluation.abilities.measure import ABILITIES, Measured
from lerobot_llakey.evaluation.abilities.report import ability_table, markdown, verbs_of, write_tables
from lerobot_llakey.evaluation.abilities.score import OUTSIDE

SEQUENTIAL, CORRECTION = ABILITIES


@pytest.fixture
def measured() -> Measured:
    measured = Measured()
    measured.add(SEQUENTIAL, "move_cup", "", "grasp the cup", "grasp the cup")
    for _ in range(3):
        measured.add(SEQUENTIAL, "my task", "drop", "grasp the cup", "sing")
    measured.add(CORRECTION, "move_cup", "", "grasp the cup", "release the cup")
    return measured


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.split("|")[1:-1]]


def test_every_task_stands_beside_the_papers_figures_and_the_average_counts_tasks(measured):
    lines = ability_table(measured, SEQUENTIAL).splitlines()
    rows = {row[0]: row for row in map(cells, lines[2:])}
    assert rows["move_cup"][1:3] == ["1", "100.0"] and rows["move_cup"][-2:] == ["86.8", "87.0"]
    assert rows["my task"][-3:] == ["100.0", "", ""]
    assert rows["average over tasks"][2] == "50.0" and rows["average over tasks"][-2:] == ["85.5", "84.5"]
    assert rows["all samples"][2] == "25.0"


def test_events_and_the_commonest_mistakes_are_listed(measured):
    text = markdown(measured)
    assert "CoppeliaSim" in text
    after = text.split("After unforeseen events")[1].split("##")[0]
    assert cells(after.strip().splitlines()[2])[:4] == ["drop", "sequential prediction", "3", "0.0"]
    assert cells(text.split("Commonest mistakes: sequential prediction")[1].strip().splitlines()[2]) == [
        "3",
        "grasp the cup",
        "sing",
    ]
    assert "After unforeseen events" not in markdown(Measured())


def test_tables_are_written_for_programs(measured, tmp_path: Path):
    write_tables(measured, tmp_path)
    with (tmp_path / "confusions.csv").open() as file:
        wrong = list(csv.DictReader(file))
    assert [(row["task"], row["answered"], row["count"]) for row in wrong] == [
        ("my task", "sing", "3"),
        ("move_cup", "release the cup", "1"),
    ]
    with (tmp_path / "verbs.csv").open() as file:
        verbs = {(row["ability"], row["expected"], row["answered"]): row["count"] for row in csv.DictReader(file)}
    assert verbs == {
        (SEQUENTIAL, "grasp", "grasp"): "1",
        (SEQUENTIAL, "grasp", OUTSIDE): "3",
        (CORRECTION, "grasp", "release"): "1",
    }
    assert verbs_of(measured.total(SEQUENTIAL)) == ["grasp", OUTSIDE]
