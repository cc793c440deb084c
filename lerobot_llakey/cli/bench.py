"""``llakey bench``: how fast things are on this machine.

llakey bench --part=collect --num_episodes=10
llakey bench --part=render --steps=200
llakey bench --part=loader    # is loading faster than training?
llakey bench --part=action --output_dir=outputs/bench
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot.utils.device_utils import auto_select_torch_device

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.cli.output import write_results
from lerobot_llakey.evaluation.bench import bench_in_temporary_folder
from lerobot_llakey.evaluation.tables import markdown_table


@dataclass
class BenchConfig:
    """Options of ``llakey bench``.

    Attributes:
        part: collect, loader, render, action or command.
        num_episodes: episodes of each task to collect: of all nine, timed, for collect, of three to read otherwise.
        batch_size: samples of a training step.
        steps: repetitions of which the median is taken; for loader, batches.
        device: PyTorch's device; the best one found by default.
        output_dir: where results.json goes; only the table is printed without it.
    """

    part: str
    num_episodes: int = 4
    batch_size: int = 16
    steps: int = 10
    device: str | None = None
    output_dir: Path | None = None


@with_options
def run(config: BenchConfig) -> None:
    """Measure, print the figures, write the results."""
    device = config.device or str(auto_select_torch_device())
    figures = bench_in_temporary_folder(config.part, config.num_episodes, config.batch_size, config.steps, device)
    rows = [(name, f"{value:.4g}" if isinstance(value, float) else str(value)) for name, value in figures.items()]
    print(markdown_table(("figure", "value"), rows))
    write_results(config.output_dir, figures)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
