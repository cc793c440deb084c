"""A saved policy is loaded and run as LeRobot would run it."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.evaluation.rollout import Agent, run_episode
from lerobot_llakey.sim.env import LlakeySimEnv


class _Expert(torch.nn.Module):
    """Acts as the task's expert, so that the loop around it can be judged."""

    def __init__(self, env: LlakeySimEnv) -> None:
        super().__init__()
        self.env, self.last_instructions, self.resets = env, [""], 0

    def reset(self) -> None:
        self.resets += 1

    def select_action(self, batch: dict[str, Any]) -> torch.Tensor:
        assert batch[schema.STATE].shape == (1, schema.STATE_DIM)
        assert batch[schema.depth_key("front")].shape[:2] == (1, 1)
        assert batch[schema.TASK] == [self.env.task_description]
        waypoint = self.env.world.task.plan(self.env.world)[0]
        self.last_instructions = [waypoint.instruction]
        flags = (waypoint.gripper_open, waypoint.ignore_collision)
        return torch.tensor([[*waypoint.pose.position, *waypoint.pose.quaternion, *flags]])


def test_an_episode_runs_until_success() -> None:
    env = LlakeySimEnv("open_drawer", image_size=32)
    expert = _Expert(env)
    said: list[str] = []
    episode = run_episode(env, Agent(expert, lambda batch: batch, lambda action: action), 3, said.append)
    assert episode.success and episode.seed == 3 and expert.resets == 1
    assert episode.instructions == said and len(said) == 3
    assert episode.failures == ["", "", ""]
    env.close()


def test_an_episode_without_success_ends_at_the_limit() -> None:
    env = LlakeySimEnv("open_drawer", image_size=32, episode_length=2)
    expert = _Expert(env)
    expert.select_action = lambda batch: torch.tensor([[5.0, 0, 0, 1, 0, 0, 0, 1, 0]])  # type: ignore[method-assign]
    episode = run_episode(env, Agent(expert, lambda batch: batch, lambda action: action), 3)
    assert not episode.success and episode.failures == ["unreachable"] * 2
    assert np.isfinite(env.world.data.qpos).all()
    env.close()


def test_a_missing_checkpoint_is_told(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="Expected a checkpoint folder"):
        Agent.load(tmp_path / "nothing" / "here")
