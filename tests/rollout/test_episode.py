"""The loop around whoever acts, and what observers hear of it."""

from collections.abc import Mapping
from itertools import chain
from typing import Any

import numpy as np
import pytest
import torch

from fakes_protocol import Hands, small_env
from lerobot_llakey import schema
from lerobot_llakey.rollout.actors import Agent, Decision
from lerobot_llakey.rollout.episode import Episode, Observer, run_episode, success_table
from lerobot_llakey.sim.env import LlakeySimEnv


class _Notes(Observer):
    """Writes down what it hears, in order: steps, instructions, the outcome."""

    def __init__(self) -> None:
        self.heard: list[Any] = []

    def begin(self, env: LlakeySimEnv, observation: Mapping[str, Any]) -> None:
        self.step(observation)

    def decide(self, instruction: str) -> None:
        self.heard.append(instruction)

    def step(self, observation: Mapping[str, Any]) -> None:
        self.heard.append(float(observation["step"][0]))

    def end(self, episode: Episode) -> None:
        self.heard.append(episode.success)


class _Expert(torch.nn.Module):
    """Acts as the task's expert, so that the loop around it can be judged."""

    def __init__(self, env: LlakeySimEnv) -> None:
        super().__init__()
        self.env, self.last_instructions, self.resets = env, [""], 0

    def reset(self) -> None:
        self.resets += 1

    def select_action(self, batch: dict[str, Any]) -> torch.Tensor:
        assert batch[schema.STATE].shape == (1, len(schema.SIM_STATE_NAMES))
        assert batch[schema.depth_key("front")].shape[:2] == (1, 1)
        assert batch[schema.TASK] == [self.env.task_description]
        waypoint = self.env.expert_waypoint()
        assert waypoint is not None
        self.last_instructions = [waypoint.instruction]
        flags = (waypoint.gripper_open, waypoint.ignore_collision)
        return torch.tensor([[*waypoint.pose.position, *waypoint.pose.quaternion, *flags]])


def test_an_episode_runs_until_success() -> None:
    env = LlakeySimEnv("open_drawer", image_size=32)
    expert = _Expert(env)
    notes = _Notes()
    episode = run_episode(env, Agent(expert, lambda batch: batch, lambda action: action), 3, [notes])
    assert episode.success and episode.seed == 3 and expert.resets == 1
    assert len(episode.instructions) == 3
    assert notes.heard == [0.0, *chain(*zip(episode.instructions, (1.0, 2.0, 3.0), strict=True)), True]
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


def test_an_actor_may_end_an_episode() -> None:
    class Tired(Hands):
        def act(self, env: LlakeySimEnv, observation: dict[str, Any]) -> Decision | None:  # type: ignore[override]
            return super().act(env, observation) if self.step < 2 else None

    env = small_env("open_drawer")
    episode = run_episode(env, Tired(), 0)
    assert not episode.success and len(episode.actions) == 2
    env.close()


def test_what_was_drawn_before_does_not_matter() -> None:
    class Restless(Hands):
        def act(self, env: LlakeySimEnv, observation: dict[str, Any]) -> Decision:
            action, instruction = super().act(env, observation)
            return np.concatenate((action[:3] + 0.05 * torch.rand(3).numpy(), action[3:])), instruction

    env = small_env("open_drawer", episode_length=2)
    first = run_episode(env, Restless(), 1)
    torch.rand(7)
    assert run_episode(env, Restless(), 1) == first != run_episode(env, Restless(), 2)
    env.close()


def _episode(task: str, success: bool, actions: int) -> Episode:
    return Episode(task, "", 0, 0, 0, success, ["grasp the lid"] * actions, [""] * actions)


def test_success_is_counted_by_task_and_averaged_over_tasks() -> None:
    episodes = [_episode("a", True, 4), _episode("a", False, 8), _episode("b", True, 3)]
    lines = success_table(episodes).splitlines()
    assert [cell.strip() for cell in lines[2].split("|")[1:-1]] == ["a", "2", "1", "50 %", "6.0"]
    assert [cell.strip() for cell in lines[-1].split("|")[1:-1]] == ["average", "3", "", "75 %", ""]


def test_no_episodes_is_told() -> None:
    with pytest.raises(ValueError, match="Expected at least one episode"):
        success_table([])
