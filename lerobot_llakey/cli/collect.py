"""``llakey collect``: let the experts demonstrate, and write what they do as LeRobotDatasets.

llakey collect --task=open_drawer,close_jar,move_block --num_episodes=100 --repo_id=me/llakey_demonstrations \
    --root=outputs/demonstrations
llakey collect --task=all --num_episodes=1000 --recovery=0.2 --execution_noise=0.3 --demonstrations=false \
    --keysteps_root=outputs/keysteps --repo_id=me/llakey_keysteps
llakey collect --task=all --num_episodes=1000 --repo_id=me/part --root=outputs/shards/3 --shard=3/16
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot.utils.constants import HF_LEROBOT_HOME

from lerobot_llakey import schema
from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.datasets.balance import Balance, sampling_mode
from lerobot_llakey.datasets.collect import collect
from lerobot_llakey.datasets.plan import CollectSettings, Targets
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.parallel import PROCESSES
from lerobot_llakey.shards import Shard
from lerobot_llakey.sim.perturbations.registry import EVENTS
from lerobot_llakey.sim.tasks import parse_tasks


@dataclass
class CollectConfig:
    """Options of ``llakey collect``.

    Attributes:
        task: task names separated by commas, or all.
        num_episodes: episodes of each task; the task's variations take turns.
        repo_id: name of the dataset on the Hub, as user/name.
        root: folder of the demonstrations; by default LeRobot's home folder.
        demonstrations: whether to write demonstrations: every frame, pictures as videos.
        keysteps_root: folder for keysteps, the training samples, beside or in place of the demonstrations.
        keystep_mode: how keysteps at keyframes count more: thin drops others, repeat stores them that often as the
            paper does, weight writes it into observation.sample_weight.
        keystep_stride: every so many-th frame becomes a keystep.
        min_per_segment: keysteps of each segment at the least.
        keyframe_repeats: how often a keystep at a keyframe counts.
        recovery: share of episodes with an unforeseen event, from which the expert recovers.
        events: the unforeseen events to draw from, separated by commas; all four by default.
        execution_noise: share of episodes in which the hand ends up to 2 cm beside its marks, and the expert goes on.
        split: of the scene seeds: train, val or test.
        first_seed: index into the split at which to begin.
        image_size: pixels of height and width.
        fps: frames a second.
        num_workers: processes; one for each CPU core where 0.
        shard: collect this part of the episodes alone, such as 3/16 for the third of sixteen; llakey merge joins them.
        engine: processes of this machine, or ray for those of a Ray cluster that shares the folders.
    """

    task: str
    num_episodes: int
    repo_id: str
    root: Path | None = None
    demonstrations: bool = True
    keysteps_root: Path | None = None
    keystep_mode: str = "thin"
    keystep_stride: int = 10
    min_per_segment: int = 3
    keyframe_repeats: int = 6
    recovery: float = 0.0
    events: str = ",".join(EVENTS)
    execution_noise: float = 0.0
    split: str = "train"
    first_seed: int = 0
    image_size: int = schema.IMAGE_SIZE
    fps: int = 10
    num_workers: int = 0
    shard: str = "1/1"
    engine: str = PROCESSES

    def settings(self) -> CollectSettings:
        """What to collect.

        Raises:
            LlakeyError: if a task or the split is unknown or a number is out of range.
        """
        return CollectSettings(
            tasks=tuple(parse_tasks(self.task)),
            num_episodes=self.num_episodes,
            split=self.split,
            first_seed=self.first_seed,
            image_size=self.image_size,
            fps=self.fps,
            balance=Balance(
                sampling_mode(self.keystep_mode), self.keystep_stride, self.min_per_segment, self.keyframe_repeats
            ),
            recovery=self.recovery,
            events=tuple(name.strip() for name in self.events.split(",") if name.strip()),
            execution_noise=self.execution_noise,
        )

    def targets(self) -> Targets:
        """Where to write.

        Raises:
            LlakeyError: if neither demonstrations nor keysteps are asked for.
        """
        if not self.demonstrations and self.keysteps_root is None:
            raise LlakeyError("Expected demonstrations or a keysteps_root, got neither; give --keysteps_root.")
        root = self.root or HF_LEROBOT_HOME / self.repo_id
        return Targets(
            demonstrations=root if self.demonstrations else None,
            keysteps=self.keysteps_root,
            demonstrations_id=self.repo_id,
            keysteps_id=f"{self.repo_id}_keysteps" if self.demonstrations else self.repo_id,
        )


@with_options
def run(config: CollectConfig) -> None:
    """Collect, and say what was discarded."""
    targets = config.targets()
    discarded = collect(
        config.settings(), targets, config.num_workers, shard=Shard.parse(config.shard), engine=config.engine
    )
    for kind, (root, _) in targets.named().items():
        print(f"{kind}: {root}")
    for reason, count in sorted(discarded.items()):
        print(f"discarded: {count} of {reason}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
