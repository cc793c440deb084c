"""``llakey table``: table I of the paper in the simulator: policies against tasks, with plots, videos and attribution.

llakey table --rows=configs/table.yaml --output_dir=outputs/table
llakey table --rows=checkpoints/llakey_small --task=open_drawer,close_jar,move_block --num_episodes=5 --repeats=3
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.evaluation.experiment import Output, foresee, report_table, run_experiment, run_shard
from lerobot_llakey.evaluation.lower_part import AbilitySamples
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.rows import read_rows
from lerobot_llakey.parallel import PROCESSES
from lerobot_llakey.shards import WHOLE, Shard
from lerobot_llakey.sim.settings import MAX_STEPS
from lerobot_llakey.sim.tasks import parse_tasks


@dataclass
class TableConfig:
    """Options of ``llakey table``.

    Attributes:
        rows: YAML file that names the policies, or checkpoints' paths separated by commas.
        task: task names separated by commas, or all.
        num_episodes: episodes of each task in a repeat.
        repeats: of all episodes, on other scenes; the best and the worst are left out of the mean.
        max_steps: actions after which an episode ends.
        split: of the scene seeds: train, val or test.
        first_seed: index of the first scene within the split.
        attribution: run failed episodes again with the oracle's instructions, to tell which level failed.
        num_videos: successes and failures of each row and task of which a video is made.
        detailed: show the robot's detailed meshes in the videos.
        num_workers: processes; one for each CPU core where 0.
        shard: run this part of the episodes alone, such as 3/16 for the third of sixteen, and make no results; the same
            command without it takes over what all shards in output_dir have done.
        engine: processes of this machine, or ray for those of a Ray cluster.
        abilities_root: folder of a keysteps dataset that no row was trained on, to measure the two abilities of the
            command policies as well; left out where None.
        abilities_repo_id: its name.
        abilities_samples: samples of it, spread evenly; all where None.
        dry_run: only say how many episodes there are and how long they take.
        output_dir: folder for results.json, table.md, plots and videos. A run that was ended goes on from it.
    """

    rows: str = "configs/table.yaml"
    task: str = "all"
    num_episodes: int = 25
    repeats: int = 6
    max_steps: int = MAX_STEPS
    split: str = "test"
    first_seed: int = 0
    attribution: bool = True
    num_videos: int = 2
    detailed: bool = False
    num_workers: int = 0
    shard: str = "1/1"
    engine: str = PROCESSES
    abilities_root: str | None = None
    abilities_repo_id: str = "local/llakey_keysteps"
    abilities_samples: int | None = None
    dry_run: bool = False
    output_dir: Path = Path("outputs/table")


@with_options
def run(config: TableConfig) -> None:
    """Run the episodes that are missing, write everything, print the tables."""
    plan = Plan(
        tuple(parse_tasks(config.task)),
        config.num_episodes,
        config.repeats,
        config.max_steps,
        config.split,
        config.first_seed,
        attribution=config.attribution,
    )
    rows = read_rows(config.rows)
    output = Output(config.output_dir, config.num_videos, config.detailed, config.num_workers, config.engine)
    shard = Shard.parse(config.shard)
    if config.dry_run:
        print(foresee(plan, rows, output, shard))
        return
    if shard != WHOLE:
        print(f"shard: {run_shard(plan, rows, output, shard).resolve()}")
        return
    samples = None
    if config.abilities_root is not None:
        samples = AbilitySamples(config.abilities_root, config.abilities_repo_id, config.abilities_samples)
    print(run_experiment(plan, rows, output, report_table, samples))
    print(f"results: {config.output_dir.resolve()}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
