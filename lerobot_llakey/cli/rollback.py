"""``llakey rollback``: figure 6 of the paper in the simulator: how often policies recover from unforeseen events.

llakey rollback --rows=configs/table.yaml --output_dir=outputs/rollback
llakey rollback --rows=checkpoints/llakey_small --task=close_jar --disturbance=drop,shift --num_episodes=10
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.experiment import Output, foresee, report_rollback, run_experiment, run_shard
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.rows import read_rows
from lerobot_llakey.parallel import PROCESSES
from lerobot_llakey.shards import WHOLE, Shard
from lerobot_llakey.sim.settings import MAX_STEPS
from lerobot_llakey.sim.tasks import parse_tasks


@dataclass
class RollbackConfig:
    """Options of ``llakey rollback``.

    Attributes:
        rows: YAML file that names the policies, or checkpoints' paths separated by commas.
        task: task names separated by commas, or all.
        disturbance: unforeseen events separated by commas.
        num_episodes: episodes of each task and event.
        max_steps: actions after which an episode ends.
        split: of the scene seeds: train, val or test.
        first_seed: index of the first scene within the split.
        attribution: run failed episodes again with the oracle's instructions, to tell which level failed.
        num_videos: recoveries and failures of each row, task and event of which a video is made.
        detailed: show the robot's detailed meshes in the videos.
        num_workers: processes; one for each CPU core where 0.
        shard: run this part of the episodes alone, such as 3/16 for the third of sixteen, and make no results; the same
            command without it takes over what all shards in output_dir have done.
        engine: processes of this machine, or ray for those of a Ray cluster.
        dry_run: only say how many episodes there are and how long they take.
        output_dir: folder for results.json, table.md, the plot and videos. A run that was ended goes on from it.
    """

    rows: str = "configs/table.yaml"
    task: str = "all"
    disturbance: str = "drop,block,shift,empty_grasp"
    num_episodes: int = 25
    max_steps: int = MAX_STEPS
    split: str = "test"
    first_seed: int = 0
    attribution: bool = True
    num_videos: int = 1
    detailed: bool = False
    num_workers: int = 0
    shard: str = "1/1"
    engine: str = PROCESSES
    dry_run: bool = False
    output_dir: Path = Path("outputs/rollback")


@with_options
def run(config: RollbackConfig) -> None:
    """Run the episodes that are missing, write everything, print the table."""
    events = tuple(event.strip() for event in config.disturbance.split(",") if event.strip())
    if not events:
        raise LlakeyError("Expected at least one event, got none; name some in --disturbance.")
    plan = Plan(
        tuple(parse_tasks(config.task)),
        config.num_episodes,
        repeats=1,
        max_steps=config.max_steps,
        split=config.split,
        first_seed=config.first_seed,
        disturbances=events,
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
    print(run_experiment(plan, rows, output, report_rollback))
    print(f"results: {config.output_dir.resolve()}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
