"""The figures of a command policy's abilities in a folder."""

from __future__ import annotations

import json
from pathlib import Path

from lerobot_llakey.evaluation.abilities.measure import Measured
from lerobot_llakey.evaluation.abilities.plots import plot_abilities, plot_verbs
from lerobot_llakey.evaluation.abilities.report import write_tables
from lerobot_llakey.files import write_whole


def write_abilities(measured: Measured, folder: Path) -> list[Path]:
    """Write ``results.json``, ``abilities.md``, the tables in CSV and both plots.

    Args:
        measured: the answers, counted.
        folder: made where it is missing.

    Returns:
        The files.
    """
    results = folder / "results.json"
    write_whole(results, json.dumps(measured.summary(), indent=2))
    written = [results, *write_tables(measured, folder)]
    for name, plot in (("abilities.png", plot_abilities), ("verbs.png", plot_verbs)):
        plot(measured, folder / name)
        written.append(folder / name)
    return written
