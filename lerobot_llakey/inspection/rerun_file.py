"""Recordings for the rerun viewer (the ``viz`` extra): one decision, and what any other recording needs."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
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
            "Expected the rerun viewer's library, got none; pip install 'lerobot_policy_llakey[viz]', or leave --rerun "
            "out and ask for a page."
        ) from error


@contextmanager
def recording_to(path: Path | None, name: str) -> Iterator[Any]:
    """A recording that is written to an .rrd file, whole or not at all, or shown in the viewer without one.

    Args:
        path: of the file; None opens the viewer.
        name: of the recording.

    Raises:
        LlakeyError: if rerun is not installed or the file cannot be written.
    """
    rerun = require_rerun()
    recording = rerun.RecordingStream(name)
    if path is None:
        recording.spawn()
        yield recording
        recording.flush()
        return
    with replacing(path) as fresh:
        recording.save(str(fresh))
        yield recording
        recording.flush()


def write_rerun(trace: Trace, path: Path) -> None:
    """Save cloud, cameras, virtual views with heatmaps, and both hands as an .rrd file.

    Raises:
        LlakeyError: if rerun is not installed.
    """
    with recording_to(path, "llakey_show") as recording:
        _record(trace, require_rerun(), recording)


def log_cloud(recording: Any, points: np.ndarray, colours: np.ndarray) -> None:
    """Log a cloud (M, 3) in metres with colours (M, 3) in 0..1."""
    paint = (np.clip(colours, 0, 1) * 255).astype(np.uint8)
    recording.log("world/cloud", require_rerun().Points3D(points, colors=paint, radii=0.002))


def log_hand(recording: Any, name: str, action: np.ndarray, colour: tuple[int, int, int], **given: Any) -> None:
    """Log the hand of an action (9,) as ``world/NAME``; further arguments are those of rerun's ``log``."""
    lines = gripper_lines(action)
    shape = require_rerun().LineStrips3D(lines, colors=[colour] * len(lines), radii=0.003)
    recording.log(f"world/{name}", shape, **given)


def _record(trace: Trace, rerun: ModuleType, recording: Any) -> None:
    recording.log("words", rerun.TextDocument("\n\n".join(report(trace))))
    recording.log("world", rerun.ViewCoordinates.RIGHT_HAND_Z_UP)
    log_cloud(recording, trace.points.numpy(), trace.colours.numpy())
    for name, action, colour in (("predicted", trace.predicted, PREDICTED), ("true", trace.true, TRUE)):
        log_hand(recording, name, action.numpy(), colour)
    for name, image in trace.cameras.items():
        recording.log(f"cameras/{name}", rerun.Image((image.clamp(0, 1) * 255).byte().numpy()))
    for stage in trace.stages:
        for view, name in enumerate(stage.views):
            picture = heatmap_over(stage.images[view].numpy(), stage.heatmap[view].numpy())
            recording.log(f"{stage.name}/{name}", rerun.Image(picture))
