"""``llakey compose``: one checkpoint out of a trained command policy and a trained action policy.

llakey compose --command_path=outputs/command/checkpoints/last/pretrained_model \\
    --action_path=outputs/action/checkpoints/last/pretrained_model --output_dir=outputs/llakey
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot.configs import parser

from lerobot_llakey.cli.errors import one_sentence


@dataclass
class ComposeConfig:
    """Options of ``llakey compose``.

    Attributes:
        command_path: Hub name or folder of the command policy.
        action_path: Hub name or folder of the action policy.
        output_dir: folder of the new checkpoint.
        half: store the weights in float16, at half the size.
    """

    command_path: str
    action_path: str
    output_dir: Path
    half: bool = False


@parser.wrap()
def run(config: ComposeConfig) -> None:
    """Join the parts and say where they went."""
    # Imported late: only this verb builds networks.
    from lerobot_llakey.policies.hierarchy.compose import compose

    compose(config.command_path, config.action_path, config.output_dir, half=config.half)
    print(f"checkpoint: {config.output_dir}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
