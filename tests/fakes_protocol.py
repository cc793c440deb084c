"""Contrived policies for tests of the paper's protocol, and a simulator of small pictures to run them in."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from lerobot_llakey.evaluation.experiment import Output, report_table, run_experiment
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.rows import EXPERT, Row
from lerobot_llakey.rollout.actors import Expert
from lerobot_llakey.sim.env import LlakeySimEnv


def small_env(task: str, split: str = "test", **settings: Any) -> LlakeySimEnv:
    """An environment whose pictures cost little."""
    return LlakeySimEnv(task, split, **{"image_size": 32, "render_size": (120, 160)} | settings)


class Hands:
    """Acts and speaks as the expert does, but for the steps at which it is made to do or say something else.

    Args:
        wrong_words: steps at which it says "raise the robotic arm" and does so.
        wrong_hands: whether it never moves, whatever is said.
        commander: as in the settings of the hierarchical policy.
    """

    def __init__(self, wrong_words: range = range(0), wrong_hands: bool = False, commander: str = "policy") -> None:
        self.wrong_words, self.wrong_hands = wrong_words, wrong_hands
        self.policy = SimpleNamespace(config=SimpleNamespace(commander=commander))
        self.step = 0

    def reset(self, seed: int | None = None) -> None:
        self.step, self.seed = 0, seed

    def act(self, env: LlakeySimEnv, observation: dict[str, Any]) -> tuple[np.ndarray, str]:
        action, instruction = Expert().act(env, observation)
        tool = observation["agent_pos"][:7]
        if self.step in self.wrong_words:
            instruction = "raise the robotic arm"
            action = np.concatenate((tool[:2], [min(tool[2] + 0.02, 0.5)], tool[3:], (1.0, 0.0)))
        if self.wrong_hands:
            action = np.concatenate((tool, (1.0, 0.0)))
        self.step += 1
        return action, instruction


def run_table(folder: str, num_workers: int = 1) -> None:
    """A table of six real episodes, for processes that are killed."""
    run_experiment(
        Plan(("open_drawer",), num_episodes=2, repeats=3),
        [Row("expert", EXPERT)],
        Output(Path(folder), num_videos=0, num_workers=num_workers),
        report_table,
    )
