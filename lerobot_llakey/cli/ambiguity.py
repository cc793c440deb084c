"""``llakey ambiguity``: figure 1 of the paper in the simulator: does success follow the verbs of the skill instruction?

llakey ambiguity --output_dir=outputs/ambiguity
llakey ambiguity --action_path=outputs/action/checkpoints/last/pretrained_model --num_demos=50 --repeats=1 \\
    --command.steps=1000 --baseline.steps=1000
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.experiments.ambiguity import PAGE, Ambiguity
from lerobot_llakey.experiments.runner import run_stages
from lerobot_llakey.experiments.settings import AmbiguitySettings, TrainingSettings
from lerobot_llakey.experiments.stages import Ledger
from lerobot_llakey.saved.folder import inspect_checkpoint
from lerobot_llakey.sim.settings import MAX_STEPS

_RECIPES = {"action": "action_small", "command": "command_small", "baseline": "action_small_baseline"}


@dataclass
class AmbiguityConfig(AmbiguitySettings):
    """Options of ``llakey ambiguity``: those of the study and these. Recipes: those of the small policies by default.

    Attributes:
        action_path: an action policy that knows put_bulb, in place of training one.
        max_steps: actions after which an episode ends.
        device: PyTorch's, of training.
        side_by_side: trainings at the same time.
        num_workers: processes that collect and evaluate; one for each CPU core where 0.
        output_dir: folder for everything. A run that was ended goes on from it.
    """

    action_path: Path | None = None
    max_steps: int = MAX_STEPS
    device: str = "cpu"
    side_by_side: int = 1
    num_workers: int = 0
    output_dir: Path = Path("outputs/ambiguity")


@with_options
def run(config: AmbiguityConfig) -> None:
    """Do what is not done, print the table."""
    for kind, recipe in _RECIPES.items():
        settings: TrainingSettings = getattr(config, kind)
        settings.recipe = settings.recipe or f"configs/{recipe}.yaml"
    if config.action_path is not None:
        inspect_checkpoint(config.action_path)
        config.action = TrainingSettings()
    folder = config.output_dir.absolute()
    study = Ambiguity(config, folder, config.device, "", config.max_steps, config.num_workers, config.action_path)
    ledger = Ledger(folder, study.stages())
    ledger.check()
    run_stages(ledger, config.side_by_side)
    print((folder / PAGE).read_text())
    print(f"results: {folder}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
