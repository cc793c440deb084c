"""``llakey determinism``: whether a seed gives the same pixels and states in every process and vector environment.

llakey determinism --task=all
"""

from dataclasses import dataclass

from lerobot_llakey import schema
from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.diagnostics.determinism import WAYS, determinism
from lerobot_llakey.reporting.tables import markdown_table
from lerobot_llakey.sim.tasks import parse_tasks


@dataclass
class DeterminismConfig:
    """Options of ``llakey determinism``.

    Attributes:
        task: task names separated by commas, or all.
        split: of the scene seed.
        seed: index into the split.
    """

    task: str = "all"
    split: str = "val"
    seed: int = 0


@with_options
def run(config: DeterminismConfig) -> None:
    """Run, print the digests' beginnings; status 1 if two of a task differ."""
    schema.scene_seed(config.split, config.seed + 1)
    found = determinism(parse_tasks(config.task), config.seed, config.split)
    rows = [(task, *(digests[way][:8] for way in WAYS)) for task, digests in found.items()]
    print(markdown_table(("task", *WAYS), rows))
    if any(len(set(digests.values())) > 1 for digests in found.values()):
        raise SystemExit(1)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
