"""``llakey drive``: watch the policy step by step, correct it in words, change its goal.

llakey drive --policy_path=checkpoints/llakey_small --task=open_drawer --seed=3
llakey drive --policy_path=checkpoints/llakey_small --task=close_jar --seed=0 --terminal
"""

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.drive.pilot import Pilot
from lerobot_llakey.drive.session import Session
from lerobot_llakey.drive.terminal import Terminal
from lerobot_llakey.rollout.actors import Agent
from lerobot_llakey.saved.folder import inspect_checkpoint
from lerobot_llakey.sim.env import LlakeySimEnv

_BARE = "--terminal"


@dataclass
class DriveConfig:
    """Options of ``llakey drive``.

    Attributes:
        policy_path: checkpoint folder or Hub name of a hierarchical policy.
        task: name of the task to begin with.
        seed: index of the scene to begin with, within the split.
        split: of the scene seeds: train, val or test.
        disturbance: what disturbs each episode: drop, block, shift, empty_grasp or execution_noise; none where empty.
        oracle: let the expert say the instructions in place of the command policy.
        max_steps: steps after which an episode is over.
        pause_seconds: how long a proposal is shown before it is carried out while the policy runs by itself.
        detailed: show the robot's detailed meshes.
        terminal: lines of text in place of a browser page.
        port: of the page, on this machine's loopback address.
        browser: open the page in the browser.
        output_dir: folder for steps and videos, a folder for each episode.
        overrides: settings of the policy by dotted name, such as '{command.base_url: "http://127.0.0.1:8000/v1"}': what
            a checkpoint says of servers, variables and paths is not taken.
    """

    policy_path: str = "checkpoints/llakey_small"
    task: str = "open_drawer"
    seed: int = 0
    split: str = "test"
    disturbance: str = ""
    oracle: bool = False
    max_steps: int = 100
    pause_seconds: float = 1.0
    detailed: bool = True
    terminal: bool = False
    port: int = 7860
    browser: bool = True
    output_dir: Path = Path("outputs/drive")
    overrides: dict[str, Any] = field(default_factory=dict)


def make_session(config: DriveConfig, agent: Agent | None = None) -> Session:
    """The session that the options ask for, with its first episode started.

    Args:
        config: the options.
        agent: the policy; loaded from ``policy_path`` where None.

    Raises:
        MissingFileError: if there is no checkpoint at the path.
        LlakeyError: if it is no hierarchical policy, or a setting of the scene is out of range.
    """

    def make_env(task: str) -> LlakeySimEnv:
        return LlakeySimEnv(
            task,
            config.split,
            episode_length=config.max_steps,
            oracle_instructions=config.oracle,
            detailed=config.detailed,
            disturbance=config.disturbance,
        )

    if agent is None:
        inspect_checkpoint(config.policy_path)
    make_env(config.task).close()  # whatever is wrong with the settings is better told before the policy is loaded
    pilot = Pilot(agent or Agent.load(config.policy_path, config.oracle, config.overrides))
    session = Session(pilot, make_env, config.output_dir, config.split, config.pause_seconds)
    session.start(config.task, config.seed)
    return session


@with_options
def drive(config: DriveConfig) -> None:
    """Start the session and hand it to a front end; close it when the person leaves."""
    taken = None
    if not config.terminal:
        from lerobot_llakey.drive.page import require_gradio
        from lerobot_llakey.serving.loopback import bind

        require_gradio()
        taken = bind(config.port)
    session = make_session(config)
    try:
        if taken is None:
            Terminal(session).talk()
        else:
            from lerobot_llakey.drive.page import serve

            serve(session, taken, config.browser)
    except KeyboardInterrupt:
        pass
    finally:
        session.close()
        print(f"steps and videos: {config.output_dir.resolve()}")


def main() -> None:
    """Run the verb with the options of the command line; ``--terminal`` alone means ``--terminal=true``."""
    sys.argv = [f"{_BARE}=true" if argument == _BARE else argument for argument in sys.argv]
    with one_sentence():
        drive()
