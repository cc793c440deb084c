"""A saved policy is loaded and run as LeRobot would run it."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from fakes_action import small_config
from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.policies.action.processor_llakey_action import make_llakey_action_pre_post_processors
from lerobot_llakey.rollout.actors import Agent, run_episode
from lerobot_llakey.sim.env import LlakeySimEnv


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


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    policy = LlakeyActionPolicy(small_config())
    policy.save_pretrained(tmp_path / "saved")
    for pipeline in make_llakey_action_pre_post_processors(policy.config):
        pipeline.save_pretrained(tmp_path / "saved")
    return tmp_path / "saved"


@pytest.mark.parametrize("kind", ["llakey_action", "act"])
@pytest.mark.parametrize("name", ["policy_preprocessor.json", "policy_postprocessor.json"])
def test_no_program_of_a_checkpoint_runs(saved: Path, tmp_path: Path, kind: str, name: str) -> None:
    assert Agent.load(saved).policy.name == "llakey_action"
    step = {"class": "subprocess.Popen", "config": {"args": ["touch", str(tmp_path / "ran")]}}
    (saved / name).write_text(json.dumps({"name": "x", "steps": [step]}))
    (saved / "config.json").write_text(json.dumps(json.loads((saved / "config.json").read_text()) | {"type": kind}))
    with pytest.raises(LlakeyError, match=rf"{name}, got 'subprocess\.Popen', which could run anything"):
        Agent.load(saved)
    assert not (tmp_path / "ran").exists()


def test_what_other_libraries_say_of_a_broken_checkpoint_becomes_one_sentence(saved: Path) -> None:
    settings = (saved / "config.json").read_text()
    for changed in ({"type": "nobody-knows"}, {"cameras": 5}, {"input_features": {"a": {}}}, {"device": []}):
        (saved / "config.json").write_text(json.dumps(json.loads(settings) | changed))
        with pytest.raises(LlakeyError, match=str(saved)):
            Agent.load(saved)
    (saved / "config.json").write_text(settings)
    file = saved / "policy_preprocessor.json"
    file.write_text(json.dumps({"name": "x", "steps": [{"registry_name": "device_processor", "config": {"a": 1}}]}))
    with pytest.raises(LlakeyError, match=str(saved)):
        Agent.load(saved)


def test_a_named_pipe_for_weights_is_refused(saved: Path) -> None:
    (saved / "model.safetensors").unlink()
    os.mkfifo(saved / "model.safetensors")
    with pytest.raises(LlakeyError, match=r"model\.safetensors, got a named pipe"):
        Agent.load(saved)


def test_settings_can_be_given_along(saved: Path) -> None:
    assert Agent.load(saved, overrides=["--crop_size=0.3"]).policy.config.crop_size == 0.3
