import logging
from pathlib import Path

import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.saved.own import given_options, is_hub_name, own_settings, without_own


def test_everything_that_names_a_server_a_variable_or_a_path_is_the_users_own() -> None:
    own = own_settings(LlakeyConfig)
    mine = {name for name in own if not name.endswith(("pretrained_path", "pretrained_revision", "repo_id"))}
    assert mine == {
        "command.base_url",
        "command.chat.api_key_env",
        "command.chat.examples",
        "command.chat.examples_root",
        "command_path",
        "action_path",
        "log_dir",
        "results_path",
    }
    assert {"repo_id", "pretrained_path", "action.pretrained_path", "command.chat.examples_repo_id"} <= set(own)


def test_saved_values_are_shown_and_ignored(caplog: pytest.LogCaptureFixture, tmp_path: Path) -> None:
    saved = {
        "log_dir": "/home/somebody/.config/autostart",
        "command": {"base_url": "http://far.away/v1", "chat": {"api_key_env": "HF_TOKEN", "examples": 4}},
    }
    with caplog.at_level(logging.WARNING):
        without_own(LlakeyConfig, saved, tmp_path)
    assert saved["log_dir"] is None
    command = saved["command"]
    assert (command["base_url"], command["chat"]["api_key_env"], command["chat"]["examples"]) == (
        "",
        "OPENAI_API_KEY",
        0,
    )
    lines = [record.getMessage() for record in caplog.records]
    assert len(lines) == 4
    assert any(
        "command.base_url='http://far.away/v1'; ignored: give --policy.command.base_url=" in line for line in lines
    )


def test_what_the_user_gives_is_not_said_to_be_ignored(caplog: pytest.LogCaptureFixture, tmp_path: Path) -> None:
    saved = {"log_dir": "somewhere", "seed": 3}
    without_own(LlakeyConfig, saved, tmp_path, ["--log_dir=here"])
    assert saved["seed"] == 3
    assert not caplog.records


def test_weights_named_by_a_path_are_refused_and_by_a_hub_name_taken(tmp_path: Path) -> None:
    without_own(LlakeyActionConfig, {"text_model": "openai/clip-vit-base-patch32"}, tmp_path)
    for path in (str(tmp_path), "../clip", "/nowhere/at/all", "~/clip"):
        with pytest.raises(LlakeyError, match=r"if it is yours, give --policy\.text_model="):
            without_own(LlakeyActionConfig, {"text_model": path}, tmp_path)
        without_own(LlakeyActionConfig, {"text_model": path}, tmp_path, [f"--text_model={path}"])


def test_a_language_model_that_the_checkpoint_holds_may_have_come_from_a_path(tmp_path: Path) -> None:
    saved = {"model": "/models/llava", "backend": "local"}
    with pytest.raises(LlakeyError, match="names the place '/models/llava'"):
        without_own(LlakeyCommandConfig, saved, tmp_path)
    (tmp_path / "language_model").mkdir()
    without_own(LlakeyCommandConfig, saved, tmp_path)


def test_what_the_user_gave_goes_on_to_a_part() -> None:
    config = LlakeyCommandConfig(device="cpu", base_url="http://127.0.0.1:1/v1")
    config.chat.api_key_env = "MY_KEY"
    assert given_options(config) == ['--base_url="http://127.0.0.1:1/v1"', '--chat.api_key_env="MY_KEY"']
    assert not given_options(LlakeyConfig(device="cpu"))


@pytest.mark.parametrize(("name", "is_one"), [("a/b", True), ("gpt2", True), ("a/b/c", False), ("a/..", False)])
def test_hub_names(name: str, is_one: bool) -> None:
    assert is_hub_name(name) is is_one
