"""``llakey expert``: how often the scripted experts succeed on unseen scenes, and whether their keyframes are found.

llakey expert --task=all --num_episodes=100 --output_dir=outputs/expert
llakey expert --task=all --num_episodes=50 --disturbance=drop
"""

from dataclasses import asdict, dataclass
from pathlib import Path

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.cli.output import write_results
from lerobot_llakey.diagnostics.expert_success import evaluate_experts, summarise, table
from lerobot_llakey.sim.tasks import parse_tasks


@dataclass
class ExpertConfig:
    """Options of ``llakey expert``.

    Attributes:
        task: task names separated by commas, or all.
        num_episodes: episodes of each task; the task's variations take turns.
        split: of the scene seeds: val or test hold scenes that no training demonstration shows.
        disturbance: what disturbs each episode: drop, block, shift, empty_grasp or execution_noise; none where empty.
        output_dir: where results.json goes; only the table is printed without it.
        num_workers: processes; one for each CPU core where 0.
    """

    task: str = "all"
    num_episodes: int = 100
    split: str = "test"
    disturbance: str = ""
    output_dir: Path | None = None
    num_workers: int = 0


@with_options
def run(config: ExpertConfig) -> None:
    """Evaluate, print the table, write the results."""
    tasks = parse_tasks(config.task)
    trials = evaluate_experts(tasks, config.num_episodes, config.split, config.num_workers, config.disturbance)
    summary = summarise(trials)
    print(table(summary))
    results = {
        "split": config.split,
        "disturbance": config.disturbance,
        "tasks": summary,
        "trials": [asdict(trial) for trial in trials],
    }
    write_results(config.output_dir, results)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
