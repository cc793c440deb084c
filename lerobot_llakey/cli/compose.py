"""``llakey compose``: one checkpoint out of a trained command policy and a trained action policy, and back.

llakey compose --command_path=outputs/command/checkpoints/last/pretrained_model \\
    --action_path=outputs/action/checkpoints/last/pretrained_model --output_dir=outputs/llakey
llakey compose --split=true --policy_path=outputs/llakey --output_dir=outputs/parts
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.errors import LlakeyError


@dataclass
class ComposeConfig:
    """Options of ``llakey compose``.

    Attributes:
        output_dir: folder of the new checkpoint; with split, ``command`` and ``action`` are written into it.
        command_path: Hub name or folder of the command policy.
        action_path: Hub name or folder of the action policy.
        policy_path: Hub name or folder of a checkpoint that holds both, to be split.
        split: make two checkpoints out of one.
        half: store the weights in float16, at half the size.
    """

    output_dir: Path
    command_path: str | None = None
    action_path: str | None = None
    policy_path: str | None = None
    split: bool = False
    half: bool = False

    def check(self) -> None:
        """Refuse paths that do not go with the way.

        Raises:
            LlakeyError: if there are others than are needed.
        """
        paths = {"command_path": self.command_path, "action_path": self.action_path, "policy_path": self.policy_path}
        given = [name for name, path in paths.items() if path is not None]
        wanted = ["policy_path"] if self.split else ["command_path", "action_path"]
        if given != wanted:
            raise LlakeyError(
                f"Expected {' and '.join(f'--{name}' for name in wanted)} with --split={str(self.split).lower()}, got "
                f"{' and '.join(f'--{name}' for name in given) or 'no path'}; give just these."
            )


@with_options
def run(config: ComposeConfig) -> None:
    """Join the parts, or take them apart, and say where they went."""
    config.check()
    # Imported late: only this verb builds networks.
    from lerobot_llakey.policies.hierarchy.compose import compose, split

    if config.policy_path is not None:
        for folder in split(config.policy_path, config.output_dir, half=config.half):
            print(f"checkpoint: {folder}")
    elif config.command_path is not None and config.action_path is not None:
        compose(config.command_path, config.action_path, config.output_dir, half=config.half)
        print(f"checkpoint: {config.output_dir}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
