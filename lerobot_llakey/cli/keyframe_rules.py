"""``llakey keyframe-rules``: how well each rule finds keyframes in recordings of known truth that never rest.

llakey keyframe-rules --task=all --num_episodes=10 --output_dir=outputs/keyframe_rules
"""

from dataclasses import asdict, dataclass, field
from pathlib import Path

from lerobot_llakey.bounds import require_texts
from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.cli.output import write_results
from lerobot_llakey.diagnostics.keyframe_rules import measure_rules, summary, table
from lerobot_llakey.sim.tasks import parse_tasks


@dataclass
class KeyframeRulesConfig:
    """Options of ``llakey keyframe-rules``.

    Attributes:
        task: task names separated by commas, or all.
        num_episodes: recordings of each task; ways to record take turns.
        rules: choices of rules, as [rest,waypoints,rest+waypoints].
        replay: those of them whose keyframes alone are done again in the simulator.
        split: of the scene seeds; defaults were chosen on train.
        first_seed: index of the first scene within the split.
        output_dir: where results.json goes; only the table is printed without it.
        num_workers: processes; one for each CPU core where 0.
    """

    task: str = "all"
    num_episodes: int = 10
    rules: list[str] = field(default_factory=lambda: ["rest", "waypoints", "speed", "rest+waypoints"])
    replay: list[str] = field(default_factory=lambda: ["waypoints"])
    split: str = "val"
    first_seed: int = 0
    output_dir: Path | None = None
    num_workers: int = 0


@with_options
def run(config: KeyframeRulesConfig) -> None:
    """Record, find keyframes, print the table, write the results."""
    require_texts("--rules", config.rules, some=True)
    require_texts("--replay", config.replay)
    tasks = parse_tasks(config.task)
    scores = measure_rules(
        tasks,
        config.num_episodes,
        config.rules,
        config.replay,
        config.split,
        config.first_seed,
        config.num_workers,
    )
    print(table(scores))
    results = {
        "split": config.split,
        "rules": {choice: summary([one for one in scores if one.rules == choice]) for choice in config.rules},
        "recordings": [asdict(score) for score in scores],
    }
    write_results(config.output_dir, results)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
