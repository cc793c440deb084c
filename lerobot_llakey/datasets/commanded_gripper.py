"""Whether a recorded gripper is open: as it was commanded, or else as far as it gets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.hand import OPENINGS, names_of, plain_name
from lerobot_llakey.labels import is_open

_CLOSED = 0.05
"""A gripper that never opens farther than this share is closed throughout."""
_COMMANDS = (*OPENINGS, "gripper_open", "gripper_command", "gripper_action")


def command_column(feature: Mapping[str, Any] | None, gripper: str | None = None) -> int | None:
    """Place of the gripper's command in a recorded action; None where its names do not tell.

    Args:
        feature: LeRobot's description of the action.
        gripper: name that the person gives to the gripper, in the state and so in the action.
    """
    names = names_of(feature) if feature else []
    if tuple(names) == schema.ACTION_NAMES:  # ours, which names the next keyframe and not this frame's command
        return None
    found = [place for place, name in enumerate(names) if name == gripper or plain_name(name) in _COMMANDS]
    return found[0] if len(found) == 1 else None


def gripper_opened(openings: np.ndarray, commands: np.ndarray | None = None) -> np.ndarray:
    """Whether the gripper is open in each frame of a whole recording.

    Commands decide where there are some and they change: those nearer to the widest one than to the narrowest one are
    to open. The sign is the one that agrees with the openings, as some recorders write 1 for closed. Otherwise a
    gripper is open where it is within a tenth of the greatest opening that it reaches in the recording, be it wider or
    narrower than another robot's: one that holds something wide is closed.

    Args:
        openings: (T,) 0..1.
        commands: (T,) in any unit.
    """
    if commands is not None and np.isfinite(commands).all() and np.ptp(commands) > 0:
        opened = commands > (commands.min() + commands.max()) / 2
        return ~opened if openings[opened].mean() < openings[~opened].mean() else opened
    return is_open(openings, float(openings.max())) & (openings > _CLOSED)
