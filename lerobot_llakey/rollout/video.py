"""A video of one episode, with the words on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from lerobot.utils.io_utils import write_video

from lerobot_llakey.files import replacing
from lerobot_llakey.rollout.captions import annotate_frame
from lerobot_llakey.sim.env import LlakeySimEnv

_FPS, _HOLD_FRAMES = 20, 20


class Film:
    """Records what an environment simulates from now on.

    Args:
        env: its next episode is filmed.
    """

    def __init__(self, env: LlakeySimEnv) -> None:
        self._env, self._instruction = env, ""
        self._frames: list[np.ndarray] = []
        env.watch(self._take, _FPS)

    def say(self, instruction: str) -> None:
        """Show this basic instruction on the frames that follow."""
        self._instruction = instruction

    def save(self, path: Path, success: bool) -> None:
        """Stop recording and write the video, whole or not at all, with the outcome on its last frames.

        Args:
            path: an mp4 file; its folder is made where it is missing.
            success: the outcome.
        """
        self._env.watch(None)
        last = annotate_frame(self._env.render(), self._env.task_description, self._instruction, success)
        with replacing(path) as unfinished:
            write_video(unfinished, [*self._frames, *[last] * _HOLD_FRAMES], _FPS)

    def _take(self, frame: np.ndarray) -> None:
        self._frames.append(annotate_frame(frame, self._env.task_description, self._instruction))
