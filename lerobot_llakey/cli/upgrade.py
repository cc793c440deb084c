"""``llakey upgrade``: bring a dataset of the first data contract to the present one.

llakey upgrade --root=outputs/keysteps --output_root=outputs/keysteps_new
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.datasets.upgrade import upgrade


@dataclass
class UpgradeConfig:
    """Options of ``llakey upgrade``.

    Attributes:
        root: folder of the dataset, left as it is.
        output_root: folder of the new one, which must not exist yet.
    """

    root: Path
    output_root: Path


@with_options
def run(config: UpgradeConfig) -> None:
    """Write the dataset anew and say where."""
    upgrade(config.root, config.output_root)
    print(f"dataset: {config.output_root}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
