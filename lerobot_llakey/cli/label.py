"""``llakey label``: correct keyframes and say instructions in a browser page of this machine.

llakey label --repo_id=me/recordings --root=outputs/recordings --instructions=instructions.csv

The page plays an episode and shows its keyframes on a time line. Every correction is in the CSV file before the next
one; killed and started again, it goes on there. ``llakey annotate --instructions=instructions.csv`` reads the file.
Keyframes begin as those in the file, else as `annotate` discovers them; to try other rules for these first, let
``llakey annotate --template=instructions.csv`` write the file. The recording is only read.
"""

import threading
import webbrowser
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.datasets.annotate import find_keyframes
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import alone_with
from lerobot_llakey.grammar import BASIC, Grammar
from lerobot_llakey.labelling.pictures import Pictures
from lerobot_llakey.labelling.session import LabelSession


@dataclass
class LabelConfig:
    """Options of ``llakey label``.

    Attributes:
        repo_id: your recordings, on the Hub or in the folder ``root``.
        root: their folder; by default LeRobot's home folder or the Hub.
        instructions: CSV file of keyframes and instructions, taken up where it exists.
        state_names: of the state's numbers, in place of those that were recorded: [x,y,z,qw,qx,qy,qz,jaw,joint_1].
        rotation: how the hand's rotation is written where names do not tell, see `llakey annotate --help`.
        gripper: name of the number that is the gripper's opening, where it is called otherwise than "gripper".
        gripper_range: its values when closed and when open, as [0,100].
        grammar: which texts are instructions: basic, free (any sentence), or a YAML file (docs/words.md).
        port: of the page, on this machine's loopback address.
        browser: open the page in the browser.
    """

    repo_id: str
    root: Path | None = None
    instructions: Path = Path("instructions.csv")
    state_names: list[str] | None = None
    rotation: str | None = None
    gripper: str | None = None
    gripper_range: list[float] = field(default_factory=lambda: [0.0, 1.0])
    grammar: str = BASIC
    port: int = 7870
    browser: bool = True


@with_options
def run(config: LabelConfig) -> None:
    """Find the keyframes, serve the page until the process is interrupted (Ctrl-C)."""
    if config.instructions.suffix != ".csv":
        raise LlakeyError(
            f"Expected --instructions to be a file whose name ends with .csv, got {config.instructions}; name it so."
        )
    make_app, served, bind = _require_server()
    with alone_with(config.instructions, "--instructions"), bind(config.port) as taken:
        grammar = Grammar.load(config.grammar)
        source = open_dataset(config.repo_id, config.root)
        wording = {name: getattr(config, name) for name in ("state_names", "rotation", "gripper", "gripper_range")}
        session = LabelSession(find_keyframes(source, **wording), config.instructions, grammar)
        page = served(make_app(session, Pictures(source), config.repo_id), taken)
        print(f"llakey label: {page.address} (Ctrl-C ends it)", flush=True)
        if config.browser:
            webbrowser.open(page.address)
        try:
            _wait()
        except KeyboardInterrupt:
            done = sum(map(session.complete, session.found))
            print(f"\n{done} of {len(session.found)} episodes complete; the same command goes on with {session.path}")
        finally:
            page.close()


def _wait() -> None:
    threading.Event().wait()


def _require_server() -> Any:
    try:
        import uvicorn  # noqa: F401

        from lerobot_llakey.labelling.server import make_app
        from lerobot_llakey.serving.loopback import Served, bind
    except ImportError as error:
        raise LlakeyError(
            "Expected the packages starlette and uvicorn for the page of llakey label, got none; "
            "pip install 'lerobot_policy_llakey[label]'."
        ) from error
    return make_app, Served, bind


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
