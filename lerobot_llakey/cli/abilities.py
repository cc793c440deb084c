"""``llakey abilities``: how well a command policy names the next instruction, at keyframes and in between.

llakey abilities --policy_path=checkpoints/llakey_small --repo_id=local/llakey_keysteps_val \\
    --root=data/llakey_keysteps_val --output_dir=outputs/abilities
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.abilities.files import write_abilities
from lerobot_llakey.evaluation.abilities.measure import measure
from lerobot_llakey.evaluation.abilities.report import markdown
from lerobot_llakey.rollout.actors import Agent
from lerobot_llakey.saved.folder import inspect_checkpoint


@dataclass
class AbilitiesConfig:
    """Options of ``llakey abilities``.

    Attributes:
        policy_path: folder or Hub name of an llakey_command or llakey checkpoint.
        repo_id: name of a keysteps or demonstrations dataset that the policy was not trained on.
        root: its folder; LeRobot's home folder by default.
        constrain: whether answers are held to the instructions known from training; as the checkpoint says by default.
        hold: whether the previous instruction is the answer while the arm moves, where the checkpoint says so and the
            dataset has velocities; false asks the model about every frame.
        max_samples: spread evenly over the dataset; all where None.
        batch_size: samples decided on at once.
        num_workers: processes that load the data.
        output_dir: where results.json, abilities.md, abilities.png, verbs.png, verbs.csv and confusions.csv go; only
            the tables are printed without it.
        overrides: settings of the policy by dotted name, such as '{command.base_url: "http://127.0.0.1:8000/v1"}': what
            a checkpoint says of servers, variables and paths is not taken.
    """

    policy_path: str
    repo_id: str
    root: Path | None = None
    constrain: bool | None = None
    hold: bool = True
    max_samples: int | None = None
    batch_size: int = 32
    num_workers: int = 0
    output_dir: Path | None = None
    overrides: dict[str, Any] = field(default_factory=dict)


def command_policy(policy: Any, path: str) -> Any:
    """The part of a policy that names instructions.

    Raises:
        LlakeyError: if it has none.
    """
    command = getattr(policy, "command", policy)
    if not hasattr(command, "next_instructions") or getattr(command.config, "target", "instruction") != "instruction":
        raise LlakeyError(
            f"Expected a policy that names instructions, got {policy.config.type!r} in {path}, which only acts; give "
            "an llakey_command or llakey checkpoint, or measure this one with `llakey keyframe-accuracy`."
        )
    return command


@with_options
def run(config: AbilitiesConfig) -> None:
    """Measure, print the tables, write the results."""
    inspect_checkpoint(config.policy_path)  # before a dataset is fetched for it
    dataset = open_dataset(config.repo_id, config.root)
    agent = Agent.load(config.policy_path, overrides=config.overrides, dataset_meta=dataset.meta)
    policy = command_policy(agent.policy, config.policy_path)
    if config.constrain is not None:
        policy.config.constrain = config.constrain
    if not config.hold:
        policy.config.hold_above = None
    measured = measure(policy, agent.preprocessor, dataset, config.batch_size, config.max_samples, config.num_workers)
    print(markdown(measured))
    if policy.gated:
        print(f"The model was asked about {policy.answered} frames, not about {policy.gated} in which the arm moved.")
    if config.output_dir is not None:
        written = write_abilities(measured, config.output_dir)
        print("\n".join(f"{path.stem}: {path}" for path in written))


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
