"""One decision as a recording for the rerun viewer (LeRobot's ``viz`` extra)."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import replacing
from lerobot_llakey.inspection.oblique_view import gripper_lines
from lerobot_llakey.inspection.page import PREDICTED, TRUE, heat_over, report
from lerobot_llakey.inspection.trace import Look


def require_rerun() -> ModuleType:
    """The rerun library.

    Raises:
        LlakeyError: if it is not installed.
    """
    try:
        return importlib.import_module("rerun")
    except ImportError as error:
        raise LlakeyError(
            "Expected the rerun viewer's library for --rerun, got none; install LeRobot's extra lerobot[viz] or leave "
            "--rerun out."
        ) from error


def write_rerun(look: Look, path: Path) -> None:
    """Save cloud, cameras, virtual views with heat maps, and both hands as an .rrd file.

    Raises:
        LlakeyError: if rerun is not installed.
    """
    rerun = require_rerun()
    recording = rerun.RecordingStream("llakey_show")
    with replacing(path) as fresh:
        recording.save(str(fresh))
        _record(look, rerun, recording)
        recording.flush()


def _record(look: Look, rerun: ModuleType, recording: Any) -> None:
    recording.log("words", rerun.TextDocument("\n\n".join(report(look))))
    recording.log("world", rerun.ViewCoordinates.RIGHT_HAND_Z_UP)
    colours = (np.clip(look.colours.numpy(), 0, 1) * 255).astype(np.uint8)
    recording.log("world/cloud", rerun.Points3D(look.points.numpy(), colors=colours, radii=0.002))
    for name, action, colour in (("predicted", look.predicted, PREDICTED), ("true", look.true, TRUE)):
        lines = gripper_lines(action.numpy())
        recording.log(f"world/{name}", rerun.LineStrips3D(lines, colors=[colour] * len(lines), radii=0.003))
    for name, image in look.cameras.items():
        recording.log(f"cameras/{name}", rerun.Image((image.clamp(0, 1) * 255).byte().numpy()))
    for stage in look.stages:
        for view, name in enumerate(stage.views):
            picture = heat_over(stage.images[view].numpy(), stage.heat[view].numpy())
            recording.log(f"{stage.name}/{name}", rerun.Image(picture))
