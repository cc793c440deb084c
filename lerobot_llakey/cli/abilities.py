"""``llakey abilities``: how well a command policy names the next instruction, at keyframes and in between.

llakey abilities --policy_path=checkpoints/llakey_small --repo_id=local/llakey_keysteps_val \\
    --root=data/llakey_keysteps_val --output_dir=outputs/abilities
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot.configs import parser
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.cli.output import write_results
from lerobot_llakey.evaluation.abilities import ALL_TASKS, abilities
from lerobot_llakey.evaluation.rollout import Agent
from lerobot_llakey.evaluation.tables import markdown_table


@dataclass
class AbilitiesConfig:
    """Options of ``llakey abilities``.

    Attributes:
        policy_path: folder or Hub name of an llakey_command or llakey checkpoint.
        repo_id: name of a keysteps dataset that the policy was not trained on.
        root: its folder; LeRobot's home folder by default.
        max_samples: spread evenly over the dataset; all where None.
        batch_size: samples decided on at once.
        output_dir: where results.json goes; only the table is printed without it.
    """

    policy_path: str
    repo_id: str
    root: Path | None = None
    max_samples: int | None = None
    batch_size: int = 32
    output_dir: Path | None = None


@parser.wrap()
def run(config: AbilitiesConfig) -> None:
    """Measure, print the table and the commonest mistakes, write the results."""
    dataset = LeRobotDataset(config.repo_id, root=config.root)
    agent = Agent.load(config.policy_path)
    policy = getattr(agent.policy, "command", agent.policy)
    figures = abilities(policy, agent.preprocessor, dataset, config.batch_size, config.max_samples)
    totals = {ability: by_task[ALL_TASKS] for ability, by_task in figures.items() if ALL_TASKS in by_task}
    rows = [
        [ability.replace("_", " "), str(total["samples"])]
        + [f"{100 * total[name]:.1f} %" for name in ("exact", "verb", "objects")]
        for ability, total in totals.items()
    ]
    print(markdown_table(["ability", "samples", "exact", "verb", "objects"], rows))
    for total in totals.values():
        for mistake in total["confusions"]:
            print(f"{mistake['count']:4d} x  {mistake['answer']!r} for {mistake['expected']!r}")
    write_results(config.output_dir, figures)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
