"""The figures of a command policy's abilities in a folder."""

from __future__ import annotations

import json
from pathlib import Path

from lerobot_llakey.evaluation.abilities.measure import Measured
from lerobot_llakey.evaluation.abilities.plots import plot_abilities, plot_verbs
from lerobot_llakey.evaluation.abilities.report import write_tables


def write_abilities(measured: Measured, folder: Path) -> None:
    """Write ``abilities.md``, the tables in CSV, both plots and ``results.json``.

    Args:
        measured: the answers, counted.
        folder: made where it is missing.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_tables(measured, folder)
    plot_abilities(measured, folder / "abilities.png")
    plot_verbs(measured, folder / "verbs.png")
    (folder / "results.json").write_text(json.dumps(measured.summary(), indent=2))
