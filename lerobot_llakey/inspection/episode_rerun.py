"""A whole episode for the rerun viewer: cloud, hand, keyframe poses, cameras and instructions over time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from lerobot_llakey import schema
from lerobot_llakey.inspection.episode_look import EpisodeLook, Moment
from lerobot_llakey.inspection.page import PREDICTED, TRUE
from lerobot_llakey.inspection.rerun_file import log_cloud, log_hand, recording_to, require_rerun

_MOST_POINTS = 10_000
"""Of a frame's cloud: every so many-th point is kept where there are more."""
_DONE = (140, 140, 150)
"""RGB of the hands at keyframes; the present hand is PREDICTED's colour, the one to be reached next TRUE's."""


def write_episode(look: EpisodeLook, path: Path | None) -> None:
    """Write an episode as an .rrd file, or show it in the viewer.

    ``world`` holds cloud, the present hand, the next keyframe's and all keyframes' with their instructions; ``cameras``
    the pictures; ``instruction`` the words; ``gripper`` the opening.

    Args:
        look: the episode.
        path: of the file; None opens the viewer.

    Raises:
        LlakeyError: if rerun is not installed or the file cannot be written.
    """
    rerun = require_rerun()
    with recording_to(path, f"llakey_{look.name}_{look.episode}".replace("/", "_")) as recording:
        recording.log("world", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        recording.log("task", rerun.TextDocument(look.task), static=True)
        for number, reached in enumerate(look.keyframes):
            log_hand(recording, f"keyframes/{number}", reached.action, _DONE, static=True)
            spot = rerun.Points3D([reached.action[schema.POSITION]], labels=[f"{number + 1}: {reached.instruction}"])
            recording.log(f"world/keyframes/{number}/instruction", spot, static=True)
        for moment in tqdm(look.moments(), total=len(look), desc="view", unit="frame"):
            _log(recording, rerun, moment)


def _log(recording: Any, rerun: Any, moment: Moment) -> None:
    recording.set_time("frame", sequence=moment.frame)
    recording.set_time("time", duration=moment.seconds)
    every = max(1, -(-len(moment.points) // _MOST_POINTS))
    log_cloud(recording, moment.points[::every], moment.colours[::every])
    log_hand(recording, "hand", np.append(moment.hand, 0.0), PREDICTED)
    log_hand(recording, "next", moment.action, TRUE)
    for name, image in moment.images.items():
        recording.log(f"cameras/{name}", rerun.Image(image))
    recording.log("instruction", rerun.TextDocument(moment.next))
    if moment.is_keyframe:
        recording.log("instructions", rerun.TextLog(f"done: {moment.leads}"))
    recording.log("gripper/opening", rerun.Scalars(float(moment.hand[schema.GRIPPER])))
