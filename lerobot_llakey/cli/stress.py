"""``llakey stress``: random legal actions in every task: does the simulator stand them?

llakey stress --task=all --num_actions=10000
"""

from dataclasses import asdict, dataclass
from pathlib import Path

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.cli.output import write_results
from lerobot_llakey.diagnostics.stress import stress
from lerobot_llakey.reporting.tables import markdown_table
from lerobot_llakey.sim.tasks import parse_tasks


@dataclass
class StressConfig:
    """Options of ``llakey stress``.

    Attributes:
        task: task names separated by commas, or all.
        num_actions: at least so many over all tasks, in whole episodes.
        split: of the scene seeds.
        num_workers: processes; one for each CPU core where 0.
        output_dir: where results.json goes; only the table is printed without it.
    """

    task: str = "all"
    num_actions: int = 10_000
    split: str = "val"
    num_workers: int = 0
    output_dir: Path | None = None


@with_options
def run(config: StressConfig) -> None:
    """Act at random, print the table, write the results; status 1 if something went wrong."""
    found = stress(parse_tasks(config.task), config.num_actions, config.split, config.num_workers)
    header = (
        "task",
        "actions",
        "moved",
        "unreachable",
        "collision",
        "not finite",
        "through the table",
        "slowest episode",
    )
    rows = [
        (
            task,
            str(one.actions),
            *(str(one.outcomes[outcome]) for outcome in ("moved", "unreachable", "collision")),
            str(one.not_finite),
            str(len(one.sunk)),
            f"{one.slowest:.1f} s",
        )
        for task, one in found.items()
    ]
    print(markdown_table(header, rows))
    write_results(config.output_dir, {task: asdict(one) for task, one in found.items()})
    if not all(one.stands for one in found.values()):
        raise SystemExit(1)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
