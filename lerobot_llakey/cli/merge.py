"""``llakey merge``: join finished datasets of the same columns into a new one.

llakey merge --roots=outputs/keysteps,outputs/dagger --root=outputs/both
llakey merge --roots='outputs/shards/*' --root=outputs/keysteps   # what llakey collect --shard=1/4 to 4/4 made
"""

from dataclasses import dataclass
from glob import glob, has_magic
from pathlib import Path

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.datasets.merge_shards import merge_shards
from lerobot_llakey.errors import LlakeyError


@dataclass
class MergeConfig:
    """Options of ``llakey merge``.

    Attributes:
        roots: folders of datasets, separated by commas, or patterns such as 'shards/*'; one that is named twice counts
            twice. Shards of a collection are put in order, and each must be there once.
        root: folder of the new dataset, which must not exist yet.
        repo_id: its name.
    """

    roots: str
    root: Path
    repo_id: str = "local/llakey_merged"


@with_options
def run(config: MergeConfig) -> None:
    """Merge and say where."""
    sources = [root for name in config.roots.split(",") if name.strip() for root in _matching(name.strip())]
    if not sources:
        raise LlakeyError(f"Expected folders of datasets in --roots, got {config.roots!r}; name one or more.")
    merge_shards(sources, config.root, config.repo_id)
    print(f"dataset: {config.root}")


def _matching(name: str) -> list[Path]:
    """The folder of this name, or those that a pattern matches."""
    return [Path(name)] if not has_magic(name) else sorted(path for path in map(Path, glob(name)) if path.is_dir())


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
