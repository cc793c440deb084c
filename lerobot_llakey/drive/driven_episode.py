"""One scene under a pilot: the environment, what is recorded of it, and nothing of who watches."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.drive.driven_step import DrivenStep
from lerobot_llakey.drive.pilot import ROW, Pilot
from lerobot_llakey.drive.streamed_video import FPS, StreamedVideo
from lerobot_llakey.policies.hierarchy.decision import Choice
from lerobot_llakey.sim.env import LlakeySimEnv

VIEWER = "viewer"
"""Name of the human's picture beside those of the policy's cameras."""
STEPS_FILE, VIDEO_FILE = "steps.jsonl", "video.mp4"


class DrivenEpisode:
    """Episodes one after the other, each with its own folder: ``steps.jsonl``, written as it goes on, and a video.

    Everything happens in the thread that calls, which must always be the same: MuJoCo's OpenGL context belongs to it.

    Args:
        pilot: who acts.
        make_env: makes the environment of a task.
        output_dir: in which each episode gets a folder ``TASK_SEED``, with a number behind it if there is one already.
        on_frame: told the human's picture (H, W, 3) at ``FPS`` simulated frames a second.

    Attributes:
        folder: of the present episode.
        own_goal: the skill instruction that the scene was made for.
        success: whether the scene's own task is done.
        over: whether the last step used up the episode's length.
        pictures: camera name, or ``VIEWER``, -> (H, W, 3) uint8, of the present state.
    """

    def __init__(
        self,
        pilot: Pilot,
        make_env: Callable[[str], LlakeySimEnv],
        output_dir: Path,
        on_frame: Callable[[np.ndarray], None],
    ) -> None:
        self._pilot, self._make_env, self._output_dir, self._on_frame = pilot, make_env, output_dir, on_frame
        self._env: LlakeySimEnv | None = None
        self._video: StreamedVideo | None = None
        self._observation: dict[str, Any] = {}
        self._instruction, self._seed = "", 0
        self.folder, self.own_goal = output_dir, ""
        self.success = self.over = False
        self.pictures: dict[str, np.ndarray] = {}

    @property
    def goal(self) -> str:
        """The goal that holds: the person's, else the scene's own."""
        return self._pilot.corrections.task(ROW) or self.own_goal

    def begin(self, task: str, seed: int) -> None:
        """Start an episode; the one before is ended.

        Args:
            task: name of a task.
            seed: index of the scene within the split.
        """
        self.end()
        if self._env is None or self._env.task != task:
            self.close()
            self._env = self._make_env(task)
        env = self._env
        self._pilot.reset()
        self.own_goal = ""
        env.watch(None)
        self._observation, info = env.reset(seed=seed)
        self._seed, self._instruction = seed, ""
        self.own_goal, self.success, self.over = env.task_description, bool(info["is_success"]), False
        self.folder = _new_folder(self._output_dir, f"{task}_{seed:03d}")
        self._video = StreamedVideo(self.folder / VIDEO_FILE)
        self._look()
        self._video.add(self.pictures[VIEWER], self.goal, "")
        env.watch(self._take, FPS)

    def propose(self) -> Choice:
        """What :meth:`step` will carry out."""
        return self._pilot.propose(self.own_goal, self._observation)

    def step(self) -> DrivenStep:
        """Carry out what was proposed last, and write it down."""
        assert self._env is not None
        action, step = self._pilot.act()
        self._instruction = step.instruction
        self._observation, _, self.success, self.over, info = self._env.step(action)
        driven = DrivenStep(step, info["failure"], self.success, self.goal == self.own_goal)
        with (self.folder / STEPS_FILE).open("a", encoding="utf-8") as file:
            scene = {"scene": {"task": self._env.task, "seed": self._seed, "split": self._env.split}}
            file.write(json.dumps(scene | driven.as_json()) + "\n")
        self._look()
        return driven

    def end(self) -> Path | None:
        """End the episode.

        Returns:
            Its video; None if there was no episode.
        """
        if self._video is None or self._env is None:
            return None
        self._env.watch(None)
        video, self._video = self._video, None
        outcome = self.success and self.goal == self.own_goal
        return video.finish(self.pictures[VIEWER], self.goal, self._instruction, outcome)

    def close(self) -> None:
        """End the episode and free the environment."""
        self.end()
        if self._env is not None:
            self._env.close()
        self._env = None

    def _look(self) -> None:
        assert self._env is not None
        views = {camera: self._observation["pixels"][camera] for camera in schema.CAMERAS}
        self.pictures = {VIEWER: self._env.render()} | views

    def _take(self, frame: np.ndarray) -> None:
        if self._video is not None:
            self._video.add(frame, self.goal, self._instruction)
        self._on_frame(frame)


def _new_folder(parent: Path, name: str) -> Path:
    """A folder that was not there before."""
    parent.mkdir(parents=True, exist_ok=True)
    number = 1
    while True:
        folder = parent / (name if number == 1 else f"{name}_{number}")
        try:
            folder.mkdir()
            return folder
        except FileExistsError:
            number += 1
