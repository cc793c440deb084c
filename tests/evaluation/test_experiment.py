"""A table in one folder: whole, killed and gone on with, in one process and in two."""

import json
import multiprocessing
import random
import time
from pathlib import Path
from typing import Any

import pytest

from fakes_protocol import run_table

_WITHOUT_OPENGL = [
    "lerobot_llakey.policies.hierarchy.modeling_llakey",
    "lerobot.datasets.lerobot_dataset",
    "lerobot.policies.factory",
    "matplotlib.backends.backend_agg",
]
"""Imported once for all runs that are killed; an OpenGL context would not survive the fork."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole")
    run_table(str(folder))
    return folder


def _episodes(folder: Path) -> dict[tuple[Any, ...], Any]:
    """By trial; no trial may stand there twice. What follows the last end of a line was cut short, and is no record."""
    finished = (folder / "episodes.jsonl").read_text().rpartition("\n")[0]
    lines = [json.loads(line) for line in finished.splitlines()]
    episodes = {tuple(line["trial"].values()): line["episode"] for line in lines}
    assert len(episodes) == len(lines)
    return episodes


def test_everything_is_written(whole: Path) -> None:
    assert {path.name for path in whole.glob("[!.]*")} == {
        "episodes.jsonl",
        "results.json",
        "settings.json",
        "table.md",
        "table.png",
    }
    results = json.loads((whole / "results.json").read_text())
    cell = results["rows"]["expert"]["tasks"]["open_drawer"]
    assert (cell["success"], cell["spread"], cell["episodes"], cell["repeats_kept"]) == (1.0, 0.0, 6, 1)
    assert "| expert " in (whole / "table.md").read_text() and "*paper: RVT*" in (whole / "table.md").read_text()
    assert len(_episodes(whole)) == 6


def test_a_run_killed_at_random_moments_ends_in_the_same_table(whole: Path, tmp_path: Path) -> None:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(_WITHOUT_OPENGL)
    rng, kills, records = random.Random(0), 0, tmp_path / "episodes.jsonl"
    for _ in range(2):
        before = _lines(records)
        run = context.Process(target=run_table, args=(str(tmp_path),))
        run.start()
        while run.is_alive() and _lines(records) == before:
            time.sleep(0.005)
        time.sleep(rng.uniform(0, 0.3))
        kills += run.is_alive()
        run.kill()
        run.join()
    assert kills, "every run had ended before it was killed"
    with records.open("ab") as file:
        file.write(b'{"trial": {"row": "exp')  # a kill in the middle of a line is rare; this is what it leaves
    run_table(str(tmp_path))
    assert _episodes(tmp_path) == _episodes(whole)
    assert (tmp_path / "table.md").read_text() == (whole / "table.md").read_text()


@pytest.mark.slow
def test_two_processes_make_the_same_table(whole: Path, tmp_path: Path) -> None:
    run_table(str(tmp_path), num_workers=2)
    assert _episodes(tmp_path) == _episodes(whole)
    assert (tmp_path / "table.md").read_text() == (whole / "table.md").read_text()


def _lines(path: Path) -> int:
    return path.read_bytes().count(b"\n") if path.exists() else 0
