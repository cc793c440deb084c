"""``llakey convert``: make demonstrations out of what others recorded in a format of their own.

llakey convert --format=rlbench --source=data/rlbench/train --tasks='[open_drawer,close_jar]' \\
    --output_repo_id=me/rlbench --output_root=outputs/rlbench
"""

from dataclasses import dataclass, field
from pathlib import Path

from lerobot.utils.constants import HF_LEROBOT_HOME

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.converters.rlbench import convert, plan_episodes
from lerobot_llakey.converters.rlbench_files import find_episodes
from lerobot_llakey.datasets.sequences import SHIPPED, read_sequences
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import BASIC, Grammar

FORMATS = ("rlbench",)


@dataclass
class ConvertConfig:
    """Options of ``llakey convert``.

    Attributes:
        source: folder of the recordings: for rlbench that of the tasks' folders, or of one task.
        output_repo_id: name of the demonstrations.
        format: of the recordings: rlbench (docs/convert_rlbench.md).
        output_root: folder of the demonstrations; by default LeRobot's home folder.
        tasks: which, as [open_drawer,close_jar]; all that are there where empty.
        cameras: which, as [front,wrist]; all that have colours and depth where empty.
        instructions: YAML file with the instructions of each task; by default those that come with the package.
        grammar: which texts are instructions: basic, free (any sentence), or a YAML file (docs/words.md).
        skip_unmatched: leave out episodes whose keyframes fit no sequence of instructions, in place of refusing them.
        num_workers: processes; one for each CPU core where 0.
    """

    source: Path
    output_repo_id: str
    format: str = FORMATS[0]
    output_root: Path | None = None
    tasks: list[str] = field(default_factory=list)
    cameras: list[str] = field(default_factory=list)
    instructions: Path | None = None
    grammar: str = BASIC
    skip_unmatched: bool = False
    num_workers: int = 0


@with_options
def run(config: ConvertConfig) -> None:
    """Write the demonstrations and say how many there are."""
    if config.format not in FORMATS:
        raise LlakeyError(f"Expected --format out of {', '.join(FORMATS)}, got {config.format!r}; pick one of these.")
    grammar = Grammar.load(config.grammar)
    instructions = read_sequences(config.instructions or SHIPPED, grammar)
    folders = find_episodes(config.source, config.tasks, config.cameras)
    episodes, left_out = plan_episodes(folders, instructions, skip_unmatched=config.skip_unmatched)
    root = config.output_root or HF_LEROBOT_HOME / config.output_repo_id
    convert(episodes, root, config.output_repo_id, grammar, config.num_workers)
    count = sum(len(episode.keyframes) for episode in episodes)
    print(f"{len(episodes)} episodes with {count} keyframes: {root}")
    if left_out:
        print(f"left out, as no sequence of instructions fits: {', '.join(map(str, left_out))}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
