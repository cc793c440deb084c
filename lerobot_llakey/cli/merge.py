"""``llakey merge``: join finished datasets of the same columns into a new one.

llakey merge --roots=outputs/keysteps,outputs/dagger --root=outputs/both
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.datasets.merge import merge
from lerobot_llakey.errors import LlakeyError


@dataclass
class MergeConfig:
    """Options of ``llakey merge``.

    Attributes:
        roots: folders of datasets, separated by commas; one that is named twice counts twice.
        root: folder of the new dataset, which must not exist yet.
        repo_id: its name.
    """

    roots: str
    root: Path
    repo_id: str = "local/llakey_merged"


@with_options
def run(config: MergeConfig) -> None:
    """Merge and say where."""
    sources = [Path(name.strip()) for name in config.roots.split(",") if name.strip()]
    if not sources:
        raise LlakeyError(f"Expected folders of datasets in --roots, got {config.roots!r}; name one or more.")
    merge(sources, config.root, config.repo_id)
    print(f"dataset: {config.root}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
