"""Whichever of LeRobot's ways loads a checkpoint: the user's own settings come from the user, nothing runs."""

import json
import sys
from pathlib import Path

import draccus
import pytest
from lerobot.configs import PreTrainedConfig
from lerobot.configs.default import DatasetConfig
from lerobot.configs.eval import EvalPipelineConfig
from lerobot.configs.train import TrainPipelineConfig

from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.saved.guard import guard_loading
from lerobot_llakey.sim.configuration_llakey_sim import LlakeySimConfig


@pytest.fixture
def checkpoint(tmp_path: Path) -> Path:
    """One that says where to write, whom to ask with which secret, and what to show."""
    folder = tmp_path / "checkpoint"
    folder.mkdir()
    config = LlakeyConfig(device="cpu", push_to_hub=False, log_dir=str(tmp_path / "written"), seed=7)
    config.command.backend, config.command.model = "chat", "evil"
    config.command.base_url = "http://127.0.0.1:9/v1"
    config.command.chat.api_key_env = "AWS_SECRET_ACCESS_KEY"
    config.save_pretrained(folder)
    run = TrainPipelineConfig(DatasetConfig("local/x"), policy=config, output_dir=tmp_path / "run")
    run.save_pretrained(folder)
    return folder


def _is_clean(config: LlakeyConfig) -> bool:
    command = config.command
    assert (config.seed, command.backend, command.model) == (7, "chat", "evil")
    return (config.log_dir, command.base_url, command.chat.api_key_env) == (None, "", "OPENAI_API_KEY")


def test_by_settings(checkpoint: Path) -> None:
    assert _is_clean(PreTrainedConfig.from_pretrained(checkpoint))
    assert _is_clean(LlakeyConfig.from_pretrained(checkpoint))


@pytest.mark.parametrize("named", [".", "train_config.json"])
def test_by_a_run_that_goes_on(checkpoint: Path, named: str) -> None:
    assert _is_clean(TrainPipelineConfig.from_pretrained(checkpoint / named, cli_args=[]).policy)
    given = TrainPipelineConfig.from_pretrained(checkpoint / named, cli_args=["--policy.log_dir=mine"]).policy
    assert given.log_dir == "mine"


def test_by_policy_path(checkpoint: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["lerobot-eval", f"--policy.path={checkpoint}"])
    assert _is_clean(EvalPipelineConfig(LlakeySimConfig()).policy)
    given = "--policy.command.base_url=http://127.0.0.1:1/v1"
    monkeypatch.setattr(sys, "argv", ["lerobot-eval", f"--policy.path={checkpoint}", given])
    config = EvalPipelineConfig(LlakeySimConfig()).policy
    assert config.command.base_url == "http://127.0.0.1:1/v1"
    assert config.command.chat.api_key_env == "OPENAI_API_KEY"


def test_a_file_of_the_users_own_is_taken_at_its_word(checkpoint: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine.json"
    mine.write_text((checkpoint / "train_config.json").read_text())
    policy = TrainPipelineConfig.from_pretrained(mine, cli_args=[]).policy
    assert policy.command.base_url == "http://127.0.0.1:9/v1"


def test_a_saved_run_may_not_name_a_policy(checkpoint: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = checkpoint / "train_config.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"policy": {"path": "x/y", "log_dir": "/tmp"}}))
    monkeypatch.setattr("lerobot.configs.parser._config_path_args", {"policy": "x/y"})
    monkeypatch.setattr(sys, "argv", ["lerobot-train", f"--config_path={file}"])
    with pytest.raises(LlakeyError, match=r"got some with a policy\.path, which no run saves"):
        TrainPipelineConfig.from_pretrained(tmp_path_of(file), cli_args=[])


def tmp_path_of(file: Path) -> Path:
    return file.parent / "cleaned.json"


def test_a_processor_that_runs_a_program_is_refused_before_lerobot_reads_it(
    checkpoint: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    step = {"class": "subprocess.Popen", "config": {"args": ["touch", str(tmp_path / "ran")]}}
    (checkpoint / "policy_preprocessor.json").write_text(json.dumps({"name": "x", "steps": [step]}))
    monkeypatch.setattr(sys, "argv", ["lerobot-eval", f"--policy.path={checkpoint}"])
    with pytest.raises(LlakeyError, match=r"policy_preprocessor\.json, got 'subprocess\.Popen', which could run"):
        EvalPipelineConfig(LlakeySimConfig())
    assert not (tmp_path / "ran").exists()


def test_wrong_settings_are_told_with_their_file(checkpoint: Path) -> None:
    file = checkpoint / "config.json"
    saved = json.loads(file.read_text())
    for changes in ({"repeat_threshold": -1}, {"seed": "x"}, {"unheard_of": 1}, {"command": [1]}, {"commander": {}}):
        file.write_text(json.dumps(saved | changes))
        with pytest.raises(LlakeyError, match=r"config\.json"):
            PreTrainedConfig.from_pretrained(checkpoint)


def test_a_path_that_is_not_there_is_told() -> None:
    with pytest.raises(MissingFileError, match="where none was found"):
        PreTrainedConfig.from_pretrained("/no/such/checkpoint")


def test_other_policies_are_left_to_lerobot(tmp_path: Path) -> None:
    from lerobot.policies.act.configuration_act import ACTConfig

    config = ACTConfig(device="cpu", push_to_hub=False, repo_id="me/act")
    config.save_pretrained(tmp_path)
    assert PreTrainedConfig.from_pretrained(tmp_path) == config


def test_guarding_twice_guards_once() -> None:
    before = PreTrainedConfig.from_pretrained.__func__
    guard_loading("lerobot_llakey")
    assert PreTrainedConfig.from_pretrained.__func__ is before


def test_settings_of_a_command_line_alone_are_the_users() -> None:
    config = draccus.parse(LlakeyConfig, args=["--command.base_url=http://127.0.0.1:1/v1", "--log_dir=here"])
    assert (config.command.base_url, config.log_dir) == ("http://127.0.0.1:1/v1", "here")
