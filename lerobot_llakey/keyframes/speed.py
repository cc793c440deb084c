"""The rule ``speed``: where the hand slows down between two moves, and where the gripper opens or closes."""

from __future__ import annotations

import numpy as np
from scipy.signal import find_peaks

from lerobot_llakey.bounds import require_number
from lerobot_llakey.keyframes.gripper import gripper_events
from lerobot_llakey.keyframes.motion import Motion
from lerobot_llakey.keyframes.waypoints import gripper_frames, hand_path

_METRES, _DEGREES = 0.02, 15.0
"""What counts as equally far, moving and turning."""
_TYPICAL = 90
"""The percentile of an episode's speeds that its minima are held against."""
_APART_SECONDS = 0.4


def speed_keyframes(motion: Motion, *, prominence: float = 0.3) -> list[int]:
    """Frames at which the hand's smoothed speed has a minimum, and those at which the gripper has opened or closed.

    Args:
        motion: one episode.
        prominence: by how much the hand is slower there than on both sides, as a share of the episode's high speed.

    Returns:
        Increasing frame indices; the last one is T - 1.

    Raises:
        LlakeyError: if the prominence makes no sense.
    """
    require_number("speed_prominence", prominence, 0, 1, open="low")
    path = hand_path(motion, _METRES, _DEGREES)
    last = len(motion) - 1
    speeds = np.linalg.norm(np.gradient(path, axis=0), axis=1) * motion.fps
    typical = float(np.percentile(speeds, _TYPICAL))
    keyframes = {last, *(frame for frame in gripper_frames(motion, path) if frame > 0)}
    if typical > 0:
        apart = max(1, round(_APART_SECONDS * motion.fps))
        minima, _ = find_peaks(-speeds, prominence=prominence * typical, distance=apart)
        busy = gripper_events(motion)
        # The hand is slow while the gripper works: that is one keyframe, the gripper's.
        free = [at for at in minima if not any(begin - apart <= at <= end + apart for begin, end in busy)]
        keyframes |= {int(at) for at in free if 0 < at < last}
    return sorted(keyframes)
