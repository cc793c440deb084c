"""``llakey keyframe-accuracy``: how often an action policy finds the next keyframe of recorded samples.

llakey keyframe-accuracy --policy_path=checkpoints/llakey_small --repo_id=local/llakey_keysteps_val \\
    --root=data/llakey_keysteps_val --output_dir=outputs/keyframe_accuracy
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.cli.output import write_results
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.evaluation.keyframe_accuracy import keyframe_accuracy
from lerobot_llakey.reporting.tables import markdown_table
from lerobot_llakey.rollout.actors import Agent
from lerobot_llakey.saved.folder import inspect_checkpoint

_COLUMNS = {
    "position_within_1cm": "1 cm",
    "position_within_2cm": "2 cm",
    "rotation_within_5deg": "5 deg",
    "rotation_within_10deg": "10 deg",
    "gripper_right": "gripper",
    "collision_right": "collision",
}


@dataclass
class KeyframeAccuracyConfig:
    """Options of ``llakey keyframe-accuracy``.

    Attributes:
        policy_path: folder or Hub name of an llakey_action or llakey checkpoint.
        repo_id: name of a keysteps dataset that the policy was not trained on.
        root: its folder; LeRobot's home folder by default.
        num_samples: drawn at random; 0 takes all.
        batch_size: samples decided on at once.
        output_dir: where results.json goes; only the table is printed without it.
        overrides: settings of the policy by dotted name, such as '{command.base_url: "http://127.0.0.1:8000/v1"}': what
            a checkpoint says of servers, variables and paths is not taken.
    """

    policy_path: str
    repo_id: str
    root: Path | None = None
    num_samples: int = 0
    batch_size: int = 16
    output_dir: Path | None = None
    overrides: dict[str, Any] = field(default_factory=dict)


@with_options
def run(config: KeyframeAccuracyConfig) -> None:
    """Measure, print the table, write the results."""
    inspect_checkpoint(config.policy_path)  # before a dataset is fetched for it
    dataset = open_dataset(config.repo_id, config.root)
    agent = Agent.load(config.policy_path, overrides=config.overrides, dataset_meta=dataset.meta)
    policy = getattr(agent.policy, "action", agent.policy)
    figures = keyframe_accuracy(policy, dataset, agent.preprocessor, None, config.num_samples, config.batch_size)
    rows = [
        [verb, f"{total['samples']:.0f}", *(f"{100 * total[name]:.0f} %" for name in _COLUMNS)]
        for verb, total in figures.items()
    ]
    print(markdown_table(["verb", "samples", *_COLUMNS.values()], rows))
    write_results(config.output_dir, figures)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
