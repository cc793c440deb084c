"""A saved policy's decisions are timed part by part, and compared alone and in batches."""

from pathlib import Path
from typing import Any

import pytest
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.policies.factory import make_policy

from fakes import fake_keysteps
from lerobot_llakey.diagnostics import bench_decision as module
from lerobot_llakey.diagnostics.bench_decision import bench_batch, bench_decision
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.rollout.actors import Agent

COMMAND = {"image_size": 32, "patch_size": 16, "vision_width": 16, "vision_heads": 2, "text_width": 32, "text_heads": 2}
ACTION = {"view_size": 32, "text_width": 32, "widths": [16, 24, 32], "transformer_heads": 2}


@pytest.fixture
def dataset(tmp_path: Path) -> LeRobotDataset:
    return fake_keysteps(tmp_path / "data", episodes=1, frames=5)


@pytest.fixture
def agent(dataset: LeRobotDataset, monkeypatch: pytest.MonkeyPatch) -> Agent:
    """A tiny hierarchy in the place of any checkpoint."""
    torch.manual_seed(0)
    command = LlakeyCommandConfig(device="cpu", **COMMAND)
    config = LlakeyConfig(command=command, action=LlakeyActionConfig(device="cpu", **ACTION), device="cpu")
    made = Agent(make_policy(config, ds_meta=dataset.meta).eval(), lambda batch: batch, lambda actions: actions)
    monkeypatch.setattr(module.Agent, "load", staticmethod(lambda *_, **__: made))
    return made


def test_each_part_is_timed_with_every_precision(agent: Agent, dataset: LeRobotDataset) -> None:
    figures = bench_decision("any", dataset, steps=1, device="cpu")
    for part in ("decision", "action", "command"):
        assert figures[f"{part}_milliseconds"] > 0 and figures[f"{part}_milliseconds_float32"] > 0
        assert figures[f"{part}_time_against_float32"] == pytest.approx(
            figures[f"{part}_milliseconds"] / figures[f"{part}_milliseconds_float32"]
        )


def test_decisions_alone_and_in_batches_are_compared(
    agent: Agent, dataset: LeRobotDataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    policy: Any = agent.policy
    decide = policy.action.select_action

    def worse_in_batches(batch: dict[str, Any]) -> torch.Tensor:
        action = decide(batch)
        action[:, 0] += 0.002 * (len(action) > 1)
        return action

    monkeypatch.setattr(policy.action, "select_action", worse_in_batches)
    figures = bench_batch("any", dataset, samples=5, batch_size=5, device="cpu")
    assert figures["samples"] == 5
    assert figures["float32_alone_against_batch_greatest_mm"] == pytest.approx(2.0, abs=0.1)
    assert figures["float32_alone_against_batch_other_instructions"] == 0
    assert figures["float32_against_bfloat16_greatest_mm"] >= figures["float32_against_bfloat16_mean_mm"] >= 0


def test_a_policy_that_only_talks_is_refused(dataset: LeRobotDataset, monkeypatch: pytest.MonkeyPatch) -> None:
    talker = LlakeyCommandPolicy(LlakeyCommandConfig(device="cpu", cameras=["front"], **COMMAND))
    agent = Agent(talker, lambda batch: batch, lambda actions: actions)
    monkeypatch.setattr(module.Agent, "load", staticmethod(lambda *_, **__: agent))
    with pytest.raises(ValueError, match="got a llakey_command at any"):
        bench_batch("any", dataset, 1, 1, "cpu")
