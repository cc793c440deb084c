"""A saved policy is loaded and run as LeRobot would run it."""

import json
import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from fakes_action import small_config
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.policies.action.processor_llakey_action import make_llakey_action_pre_post_processors
from lerobot_llakey.rollout.actors import Agent, command_line


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


def test_settings_are_written_as_on_a_command_line() -> None:
    settings = {"commander": "oracle", "command.constrain": False, "seed": 3}
    assert command_line(settings) == ["--commander=oracle", "--command.constrain=false", "--seed=3"]


def test_a_policy_that_draws_gets_the_episodes_seed() -> None:
    seeds: list[int] = []
    policy: Any = SimpleNamespace(reset=lambda: seeds.append(0), reseed=seeds.append)
    Agent(policy, lambda batch: batch, lambda action: action).reset(7)
    assert seeds == [7, 0]  # from the reset on


def test_settings_can_be_given_along(saved: Path) -> None:
    assert Agent.load(saved, overrides={"crop_size": 0.3}).policy.config.crop_size == 0.3
