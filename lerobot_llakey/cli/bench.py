"""``llakey bench``: how fast things are on this machine.

llakey bench --part=collect --num_episodes=10
llakey bench --part=render --steps=200
llakey bench --part=loader    # is loading faster than training?
llakey bench --part=action --output_dir=outputs/bench
llakey bench --part=decision --policy_path=checkpoints/llakey_small    # a saved policy, whole and part by part
llakey bench --part=batch --policy_path=checkpoints/llakey_small --batch_size=8    # do decisions depend on the batch?
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot.utils.device_utils import auto_select_torch_device

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.cli.output import write_results
from lerobot_llakey.diagnostics.bench import BenchSettings, bench_in_temporary_folder
from lerobot_llakey.reporting.tables import markdown_table
from lerobot_llakey.saved.folder import inspect_checkpoint


@dataclass
class BenchConfig:
    """Options of ``llakey bench``. Policies are measured with dtype=auto and float32 in turns.

    Attributes:
        part: collect, loader, render, action, command, decision or batch.
        num_episodes: episodes of each task to collect: of all nine, timed, for collect, of three to read otherwise.
        batch_size: samples of a training step; for batch, of those decided on together.
        steps: repetitions of which the median is taken; for loader, batches.
        device: PyTorch's device; the best one found by default.
        policy_path: the policy of decision and batch.
        samples: on how many batch decides.
        bfloat16: measure with dtype=bfloat16 too, which takes a minute a training step where no unit computes in it.
        dataset_root: folder of a keysteps dataset to measure on, in place of collecting one.
        output_dir: where results.json goes; only the table is printed without it.
    """

    part: str
    num_episodes: int = 4
    batch_size: int = 16
    steps: int = 10
    device: str | None = None
    policy_path: str | None = None
    samples: int = 64
    bfloat16: bool = False
    dataset_root: Path | None = None
    output_dir: Path | None = None


@with_options
def run(config: BenchConfig) -> None:
    """Measure, print the figures, write the results."""
    settings = BenchSettings(
        part=config.part,
        num_episodes=config.num_episodes,
        batch_size=config.batch_size,
        steps=config.steps,
        device=config.device or str(auto_select_torch_device()),
        policy_path=config.policy_path,
        samples=config.samples,
        bfloat16=config.bfloat16,
        dataset_root=config.dataset_root,
    )
    if config.policy_path is not None:
        inspect_checkpoint(config.policy_path)  # before anything is collected for it
    figures = bench_in_temporary_folder(settings)
    rows = [(name, f"{value:.4g}" if isinstance(value, float) else str(value)) for name, value in figures.items()]
    print(markdown_table(("figure", "value"), rows))
    write_results(config.output_dir, figures)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
