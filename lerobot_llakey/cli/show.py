"""``llakey show``: what an action policy sees and decides for one recorded frame.

llakey show --policy_path=checkpoints/llakey_small --repo_id=local/llakey_keysteps_val \\
    --root=data/llakey_keysteps_val --index=10 --output=outputs/show.png
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.cli.output import write_png
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.inspection.page import page, report
from lerobot_llakey.inspection.rerun_file import require_rerun, write_rerun
from lerobot_llakey.inspection.trace import trace
from lerobot_llakey.rollout.actors import Agent
from lerobot_llakey.saved.folder import inspect_checkpoint


@dataclass
class ShowConfig:
    """Options of ``llakey show``.

    Attributes:
        policy_path: folder or Hub name of an llakey_action or llakey checkpoint.
        repo_id: name of a keysteps or demonstrations dataset.
        root: its folder; LeRobot's home folder by default.
        index: of the frame in the dataset.
        output: the PNG to write.
        rerun: also save cloud, cameras and poses as this .rrd file; needs LeRobot's ``viz`` extra.
        overrides: settings of the policy by dotted name, such as '{command.base_url: "http://127.0.0.1:8000/v1"}': what
            a checkpoint says of servers, variables and paths is not taken.
    """

    policy_path: str
    repo_id: str
    root: Path | None = None
    index: int = 0
    output: Path = Path("outputs/show.png")
    rerun: Path | None = None
    overrides: dict[str, Any] = field(default_factory=dict)


@with_options
def run(config: ShowConfig) -> None:
    """Decide on the frame, write the page, print the errors."""
    if config.rerun is not None:
        require_rerun()
    inspect_checkpoint(config.policy_path)  # before a dataset is fetched for it
    dataset = open_dataset(config.repo_id, config.root)
    agent = Agent.load(config.policy_path, overrides=config.overrides, dataset_meta=dataset.meta)
    seen = trace(agent.policy, dataset, config.index, agent.preprocessor)
    write_png(config.output, page(seen))
    if config.rerun is not None:
        write_rerun(seen, config.rerun)
    print("\n".join([*report(seen), f"page: {config.output}"]))


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
