"""``llakey contact-sheet``: one page with a moment of every task, as people and as the policies see it.

llakey contact-sheet --task=all --output=docs/tasks.png
"""

from dataclasses import dataclass
from pathlib import Path

import cv2
from lerobot.configs import parser

from lerobot_llakey import schema
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.contact_sheet import contact_sheet
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


@parser.wrap()
def run(config: ContactSheetConfig) -> None:
    """Draw the page and write it."""
    if config.output.suffix != ".png":
        raise LlakeyError(f"Expected a PNG file as output, got {config.output}; let its name end with .png.")
    page = contact_sheet(parse_tasks(config.task), schema.scene_seed(config.split, config.seed), config.actions)
    config.output.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(config.output), page[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 9])
    print(config.output)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
