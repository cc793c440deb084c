"""``llakey contact-sheet``: one page with a moment of every task, as people and as the policies see it.

llakey contact-sheet --task=all --output=docs/tasks.png
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey import schema
from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.cli.output import write_png
from lerobot_llakey.diagnostics.contact_sheet import contact_sheet
from lerobot_llakey.sim.tasks import parse_tasks


@dataclass
class ContactSheetConfig:
    """Options of ``llakey contact-sheet``.

    Attributes:
        output: PNG file to write.
        task: task names separated by commas, or all.
        split: of the scene seed.
        seed: index into the split.
        actions: of the expert before the picture is taken.
    """

    output: Path
    task: str = "all"
    split: str = "val"
    seed: int = 0
    actions: int = 2


@with_options
def run(config: ContactSheetConfig) -> None:
    """Draw the page and write it."""
    page = contact_sheet(parse_tasks(config.task), schema.scene_seed(config.split, config.seed), config.actions)
    write_png(config.output, page)
    print(config.output)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
