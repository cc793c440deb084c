"""``llakey dagger``: let a policy act in the simulator, and write what the expert would have done in each state.

llakey dagger --policy_path=outputs/llakey --task=all --num_episodes=50 --root=outputs/dagger
llakey merge --roots=outputs/keysteps,outputs/dagger --root=outputs/keysteps_dagger
lerobot-train --config_path=configs/action_small.yaml --dataset.root=outputs/keysteps_dagger ...
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey import schema
from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.dagger.collect import collect
from lerobot_llakey.dagger.plan import DaggerSettings
from lerobot_llakey.saved.folder import inspect_checkpoint
from lerobot_llakey.sim.tasks import parse_tasks


@dataclass
class DaggerConfig:
    """Options of ``llakey dagger``.

    Attributes:
        policy_path: checkpoint of a hierarchical policy, a folder or a Hub name.
        task: task names separated by commas, or all.
        num_episodes: episodes of each task; in every other one the expert instructs and the action policy acts.
        root: folder of the keysteps; a run that was stopped goes on from it.
        repo_id: their name.
        expert_share: share of the actions that the expert carries out itself.
        disturbance: what disturbs each episode: drop, block, shift, empty_grasp or execution_noise; none where empty.
        max_steps: actions after which an episode ends.
        split: of the scene seeds: train, val or test.
        first_seed: index into the split at which to begin; take scenes that no demonstration has.
        image_size: pixels of height and width.
        num_workers: processes; one for each CPU core where 0.
    """

    policy_path: str
    task: str
    num_episodes: int
    root: Path
    repo_id: str = "local/llakey_dagger"
    expert_share: float = 0.2
    disturbance: str = ""
    max_steps: int = 15
    split: str = "train"
    first_seed: int = 100_000
    image_size: int = schema.IMAGE_SIZE
    num_workers: int = 0


@with_options
def run(config: DaggerConfig) -> None:
    """Collect and say where."""
    settings = DaggerSettings(
        policy_path=config.policy_path,
        tasks=tuple(parse_tasks(config.task)),
        num_episodes=config.num_episodes,
        split=config.split,
        first_seed=config.first_seed,
        image_size=config.image_size,
        max_steps=config.max_steps,
        expert_share=config.expert_share,
        disturbance=config.disturbance,
    )
    inspect_checkpoint(config.policy_path)  # before a process is started for it
    collect(settings, config.root, config.repo_id, config.num_workers)
    print(f"keysteps: {config.root}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
