"""A drive that runs small: the real environment and the real loop, with a script for the two networks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import torch
from lerobot.utils.feature_utils import dataset_to_policy_features

from lerobot_llakey import schema
from lerobot_llakey.drive.pilot import Pilot
from lerobot_llakey.drive.session import Session
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.hierarchy.commanders import Commander
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.decision import Said
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy
from lerobot_llakey.rollout.actors import Agent
from lerobot_llakey.sim.env import LlakeySimEnv

SIZE = 32
STEPS = 6


class Script(Commander):
    """Says what the expert would, and notes the goal that it was told."""

    def __init__(self, envs: list[LlakeySimEnv]) -> None:
        self.envs = envs
        self.goals: list[str] = []

    def ask(self, batch: Any, rows: Any, previous: Any) -> list[Said]:
        self.goals.append(batch[schema.TASK][0])
        return [Said(self.envs[-1].oracle_instruction() or "raise the robotic arm", "policy", 0.9)]


class Hand(torch.nn.Module):
    """Does the expert's next waypoint if its instruction is asked for, raises the hand; cannot reach anything else."""

    def __init__(self, envs: list[LlakeySimEnv]) -> None:
        super().__init__()
        self.envs = envs

    def reset(self) -> None:
        pass

    def select_action(self, batch: dict[str, Any]) -> torch.Tensor:
        env = self.envs[-1]
        instruction, state = batch[schema.INSTRUCTION][0], batch[schema.STATE][0]
        waypoint = env.expert_waypoint()
        if waypoint is not None and waypoint.instruction == instruction:
            flags = waypoint.gripper_open, waypoint.ignore_collision
            return torch.tensor([[*waypoint.pose.position, *waypoint.pose.quaternion, *flags]]).float()
        action = torch.cat((state[:7], torch.tensor([1.0, 1.0])))
        action[0] = action[0] if instruction == "raise the robotic arm" else 5.0
        action[2] += 0.05
        return action[None]


@pytest.fixture
def envs() -> list[LlakeySimEnv]:
    """The environments made so far."""
    return []


@pytest.fixture
def make_env(envs: list[LlakeySimEnv]) -> Callable[[str], LlakeySimEnv]:
    def make(task: str) -> LlakeySimEnv:
        envs.append(LlakeySimEnv(task, image_size=SIZE, render_size=(120, 160), episode_length=STEPS))
        return envs[-1]

    return make


@pytest.fixture
def script(envs: list[LlakeySimEnv]) -> Script:
    return Script(envs)


@pytest.fixture
def agent(envs: list[LlakeySimEnv], script: Script) -> Agent:
    """The hierarchical policy, told by the script and acting as the expert would."""
    action = LlakeyActionConfig(
        device="cpu",
        view_size=32,
        text_width=32,
        text_layers=1,
        text_buckets=64,
        widths=[16, 24, 32],
        transformer_layers=1,
        transformer_heads=2,
        dtype="float32",
        state_names=list(schema.SIM_STATE_NAMES),
        workspace=[list(bounds) for bounds in schema.WORKSPACE],
    )
    config = LlakeyConfig(action=action, commander="oracle", device="cpu", push_to_hub=False)
    features = dataset_to_policy_features(schema.dataset_features(dict.fromkeys(schema.CAMERAS, (SIZE, SIZE))))
    config.output_features = {schema.ACTION: features.pop(schema.ACTION)}
    config.input_features = features
    policy = LlakeyPolicy(config).eval()
    policy.loop.commander, policy.action = script, Hand(envs)  # type: ignore[assignment]
    return Agent(policy, lambda batch: batch, lambda action: action)


@pytest.fixture
def pilot(agent: Agent) -> Pilot:
    return Pilot(agent)


@pytest.fixture
def session(pilot: Pilot, make_env: Callable[[str], LlakeySimEnv], tmp_path: Path) -> Iterator[Session]:
    """A session without an episode."""
    session = Session(pilot, make_env, tmp_path / "drive", pause_seconds=0.0)
    yield session
    session.close()
