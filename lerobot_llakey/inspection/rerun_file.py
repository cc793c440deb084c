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
from lerobot_llakey.inspection.page import PREDICTED, TRUE, heatmap_over, report
from lerobot_llakey.inspection.trace import Trace


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


def write_rerun(trace: Trace, path: Path) -> None:
    """Save cloud, cameras, virtual views with heatmaps, and both hands as an .rrd file.

    Raises:
        LlakeyError: if rerun is not installed.
    """
    rerun = require_rerun()
    recording = rerun.RecordingStream("llakey_show")
    with replacing(path) as fresh:
        recording.save(str(fresh))
        _record(trace, rerun, recording)
        recording.flush()


def _record(trace: Trace, rerun: ModuleType, recording: Any) -> None:
    recording.log("words", rerun.TextDocument("\n\n".join(report(trace))))
    recording.log("world", rerun.ViewCoordinates.RIGHT_HAND_Z_UP)
    colours = (np.clip(trace.colours.numpy(), 0, 1) * 255).astype(np.uint8)
    recording.log("world/cloud", rerun.Points3D(trace.points.numpy(), colors=colours, radii=0.002))
    for name, action, colour in (("predicted", trace.predicted, PREDICTED), ("true", trace.true, TRUE)):
        lines = gripper_lines(action.numpy())
        recording.log(f"world/{name}", rerun.LineStrips3D(lines, colors=[colour] * len(lines), radii=0.003))
    for name, image in trace.cameras.items():
        recording.log(f"cameras/{name}", rerun.Image((image.clamp(0, 1) * 255).byte().numpy()))
    for stage in trace.stages:
        for view, name in enumerate(stage.views):
            picture = heatmap_over(stage.images[view].numpy(), stage.heatmap[view].numpy())
            recording.log(f"{stage.name}/{name}", rerun.Image(picture))
