"""A video of one episode, with the words on it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from lerobot.utils.io_utils import write_video

from lerobot_llakey.files import replacing
from lerobot_llakey.rollout.captions import annotate_frame
from lerobot_llakey.rollout.episode import Episode, Observer
from lerobot_llakey.sim.env import LlakeySimEnv

_FPS, _HOLD_FRAMES = 20, 20


class EpisodeVideo(Observer):
    """Records what the environment simulates in an episode, and holds the outcome on the last frames."""

    def __init__(self) -> None:
        self._instruction = ""
        self._frames: list[np.ndarray] = []

    def begin(self, env: LlakeySimEnv, observation: Mapping[str, Any]) -> None:
        """Record from now on."""
        self._env = env
        env.watch(self._take, _FPS)

    def decide(self, instruction: str) -> None:
        """Show this basic instruction on the frames that follow."""
        self._instruction = instruction

    def end(self, episode: Episode) -> None:
        """Stop recording."""
        self._env.watch(None)
        last = annotate_frame(self._env.render(), episode.description, self._instruction, episode.success)
        self._frames += [last] * _HOLD_FRAMES

    def save(self, path: Path) -> None:
        """Write the video, whole or not at all.

        Args:
            path: an mp4 file; its folder is made where it is missing.
        """
        with replacing(path) as unfinished:
            write_video(unfinished, self._frames, _FPS)

    def _take(self, frame: np.ndarray) -> None:
        self._frames.append(annotate_frame(frame, self._env.task_description, self._instruction))
