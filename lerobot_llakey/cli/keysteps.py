"""``llakey keysteps``: draw the training samples of the paper from a dataset of demonstrations.

llakey keysteps --repo_id=me/llakey_demonstrations --output_repo_id=me/llakey_keysteps --output_root=outputs/keysteps
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot.utils.constants import HF_LEROBOT_HOME

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.datasets.balance import Balance, sampling_mode
from lerobot_llakey.datasets.collect import quieten
from lerobot_llakey.datasets.keysteps import convert
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.folders import refuse_occupied


@dataclass
class KeystepsConfig:
    """Options of ``llakey keysteps``.

    Attributes:
        repo_id: demonstrations on the Hub or in the folder ``root``.
        output_repo_id: name of the keysteps.
        root: folder of the demonstrations; by default LeRobot's home folder or the Hub.
        output_root: folder of the keysteps; by default LeRobot's home folder.
        mode: how samples at keyframes count more: thin drops others, repeat stores them that often as the paper does,
            weight writes it into observation.sample_weight.
        stride: every so many-th frame is taken.
        min_per_segment: samples of each segment at the least.
        keyframe_repeats: how often a sample at a keyframe counts.
        seed: of the random choices.
    """

    repo_id: str
    output_repo_id: str
    root: Path | None = None
    output_root: Path | None = None
    mode: str = "thin"
    stride: int = 10
    min_per_segment: int = 3
    keyframe_repeats: int = 6
    seed: int = 0


@with_options
def run(config: KeystepsConfig) -> None:
    """Write the keysteps and say how many there are."""
    mode = sampling_mode(config.mode)
    balance = Balance(mode, config.stride, config.min_per_segment, config.keyframe_repeats)
    quieten()
    root = config.output_root or HF_LEROBOT_HOME / config.output_repo_id
    refuse_occupied(root)
    source = open_dataset(config.repo_id, config.root)
    count = convert(source, root, config.output_repo_id, balance=balance, seed=config.seed)
    print(f"{count} keysteps of {source.num_episodes} episodes: {root}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
