"""``llakey reproduce``: the whole paper from one command: collect, train, and every table, plot and video.

llakey reproduce --scale=toy --output_dir=outputs/reproduce_toy
llakey reproduce --scale=paper --device=cuda --output_dir=outputs/reproduce --plan_only=true
llakey reproduce --config_path=my_scale.yaml --table.repeats=3 --output_dir=outputs/mine
"""

import sys
from dataclasses import dataclass
from pathlib import Path

from lerobot.configs import parser

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.experiments.measure import measured
from lerobot_llakey.experiments.policies import ACTION, COMMAND
from lerobot_llakey.experiments.rates import Rates
from lerobot_llakey.experiments.report import write_report
from lerobot_llakey.experiments.reproduction import Reproduction, Scale
from lerobot_llakey.experiments.runner import plan_table, run_stages, time_table
from lerobot_llakey.experiments.settings import find_config
from lerobot_llakey.experiments.stages import Ledger


@dataclass
class ReproduceConfig(Scale):
    """Options of ``llakey reproduce``. All else is in the scale's file, ``configs/reproduce_SCALE.yaml``.

    Attributes:
        output_dir: folder for everything. A run that was ended goes on from it.
        device: PyTorch's, of training: cpu, cuda or mps.
        plan_only: only say what the stages are and how long they take.
        estimate: measure this machine beforehand, to say how long each stage takes.
        redo: stages to do anew, separated by commas, with all that follows from them.
    """

    output_dir: Path = Path("outputs/reproduce")
    device: str = "cpu"
    plan_only: bool = False
    estimate: bool = True
    redo: str = ""


def reproduce(config: ReproduceConfig) -> None:
    """Say what is to be done, do what is not done, write the report.

    Raises:
        LlakeyError: if the folder's work was begun with other settings, or a training fails.
    """
    whole = Reproduction(config, config.output_dir.absolute(), config.device)
    ledger = Ledger(whole.folder, whole.stages())
    side_by_side = config.train.side_by_side
    if config.redo and not config.plan_only:
        names = [name.strip() for name in config.redo.split(",")]
        print(f"to be done anew: {', '.join(ledger.forget(names))}")
    ledger.check()
    rates = measured(whole.folder, whole.tasks, whole.trainings, COMMAND, ACTION) if config.estimate else Rates()
    print(plan_table(ledger, rates, side_by_side))
    if config.plan_only:
        return
    run_stages(ledger, side_by_side)
    path = write_report(whole.folder, config.scale, whole.trainings.values(), time_table(ledger))
    print(f"report: {path}")


@with_options
def run(config: ReproduceConfig) -> None:
    """Reproduce."""
    reproduce(config)


def with_scale_file(arguments: list[str]) -> list[str]:
    """Arguments in which ``--scale=NAME`` names the scale's file too.

    Raises:
        MissingFileError: if there is no such scale.
    """
    scale = parser.parse_arg("scale", arguments)
    if parser.parse_arg("config_path", arguments) or {"--help", "-h"} & set(arguments):
        return arguments
    name = f"configs/reproduce_{scale or ReproduceConfig.scale}.yaml"
    return [f"--config_path={find_config(name)}", *arguments]


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        sys.argv = [sys.argv[0], *with_scale_file(sys.argv[1:])]
        run()
