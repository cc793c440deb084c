"""The lower part of table I: both abilities of each row's command policy."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tqdm import tqdm

from lerobot_llakey.datasets.opening import open_dataset, open_metadata
from lerobot_llakey.evaluation.abilities.measure import ABILITIES, AVERAGE, measure
from lerobot_llakey.evaluation.protocol.loading import load_row
from lerobot_llakey.evaluation.protocol.markdown import paper_rows
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.files import reading, write_whole
from lerobot_llakey.reporting import paper_results
from lerobot_llakey.reporting.tables import markdown_table
from lerobot_llakey.rollout.actors import Agent

_FILE = "abilities.json"


@dataclass(frozen=True)
class AbilitySamples:
    """Where the abilities are measured.

    Attributes:
        root: folder of a keysteps dataset that no row was trained on.
        repo_id: its name.
        max_samples: spread over the dataset; all where None.
    """

    root: str
    repo_id: str
    max_samples: int | None = None

    def check(self) -> None:
        """Look whether there is such a dataset, before anything is done that it is needed for afterwards.

        Raises:
            LlakeyError: if there is none, or its description is broken.
        """
        open_metadata(Path(self.root))


def measure_rows(rows: Sequence[Row], samples: AbilitySamples, folder: Path) -> dict[str, Any]:
    """Both abilities of each row whose policy has a command policy of its own.

    What is measured is kept in ``abilities.json``, row by row, and not measured again with the same samples.

    Returns:
        For each row, ability and task what :meth:`Measured.summary` tells.

    Raises:
        LlakeyError: if the dataset has no instructions or does not tell keyframes apart.
    """
    path = folder / _FILE
    done: dict[str, Any] = {"samples": asdict(samples), "rows": {}}
    if path.exists():
        with reading(path, "record of abilities"):
            kept = json.loads(path.read_text())
            if kept["samples"] == done["samples"]:
                done = kept
    dataset = open_dataset(samples.repo_id, Path(samples.root))
    for row in tqdm(rows, desc="abilities", unit="row"):
        if row.name in done["rows"]:
            continue
        agent = load_row(row)
        command = getattr(agent.policy, "command", None) if isinstance(agent, Agent) else None
        done["rows"][row.name] = None
        if command is not None and isinstance(agent, Agent):
            measured = measure(command, agent.preprocessor, dataset, max_samples=samples.max_samples)
            done["rows"][row.name] = measured.summary()
        write_whole(path, json.dumps(done, indent=2))
    return {name: figures for name, figures in done["rows"].items() if figures is not None}


def ability_page(tasks: Sequence[str], measured: Mapping[str, Any]) -> str:
    """A table for each ability, with the paper's figures."""
    parts = ["## Abilities of the command policies", "Shares of instructions named right, in percent."]
    for ability in ABILITIES:
        rows = [
            [row, *(_percent(figures[ability].get(task)) for task in tasks), _percent(figures[ability][AVERAGE])]
            for row, figures in measured.items()
        ]
        rows += paper_rows(paper_results.ABILITIES[ability], tasks)
        parts += [f"### {ability.replace('_', ' ').capitalize()}", markdown_table(["row", *tasks, "average"], rows)]
    return "\n\n".join(parts) + "\n"


def _percent(figures: Mapping[str, Any] | None) -> str:
    return "-" if figures is None or not figures["samples"] else f"{100 * figures['exact']:.1f}"
