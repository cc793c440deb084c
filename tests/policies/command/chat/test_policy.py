"""The chat backend as a LeRobot policy: alone, saved and loaded, and in command of an action policy."""

import json
from pathlib import Path

import pytest
import torch
from lerobot.configs import PreTrainedConfig
from lerobot.policies.factory import make_policy, make_pre_post_processors

from fakes_action import small_config
from lerobot_llakey import schema
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.hierarchy.compose import compose, save
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy

KEY = "sk-test-0123456789"
AT_ONCE = {"retry-after-ms": "1"}


@pytest.fixture
def policy(chat_config) -> LlakeyCommandPolicy:
    return LlakeyCommandPolicy(chat_config)


@pytest.fixture
def batch(batch) -> dict:
    """Of a robot that stands, so that every row is asked about."""
    return batch | {schema.VELOCITY: torch.zeros_like(batch[schema.VELOCITY])}


@pytest.fixture
def observation(batch) -> dict:
    hidden = (schema.INSTRUCTION, schema.PREVIOUS_INSTRUCTION, schema.ACTION)
    keys = [key for key in batch if key.startswith("observation.") and key not in hidden]
    return {key: batch[key][:2] for key in [*keys, schema.TASK]}


def test_it_has_no_weights_and_saves_and_loads_as_settings_alone(server, policy, batch, keysteps, tmp_path):
    assert not list(policy.parameters())
    save(policy, tmp_path)
    assert "model.safetensors" not in {path.name for path in tmp_path.iterdir()}
    config = PreTrainedConfig.from_pretrained(tmp_path, cli_overrides=[f"--base_url={server.url}"])
    loaded = LlakeyCommandPolicy.from_pretrained(tmp_path, config=config)
    assert (loaded.config.chat, loaded.config.base_url) == (policy.config.chat, policy.config.base_url)
    assert loaded.next_instructions(batch) == ["grasp the red block"] * 6
    config.pretrained_path = tmp_path
    again = make_policy(config, ds_meta=keysteps.meta)
    preprocessor, _ = make_pre_post_processors(again.config, pretrained_path=str(tmp_path))
    assert again.next_instructions(preprocessor(dict(batch))) == ["grasp the red block"] * 6


def test_the_folder_in_configs_is_a_chat_policy_to_fill_in(server, batch):
    folder = Path(__file__).parents[4] / "configs/command_chat"
    with pytest.raises(ValueError, match=r"give for example --policy\.model"):
        LlakeyCommandPolicy.from_pretrained(folder)
    flags = ["--model=tiny", f"--base_url={server.url}"]
    config = PreTrainedConfig.from_pretrained(folder, cli_overrides=flags)
    policy = LlakeyCommandPolicy.from_pretrained(folder, config=config)
    preprocessor, _ = make_pre_post_processors(config, pretrained_path=str(folder))
    assert policy.next_instructions(preprocessor(dict(batch))) == ["grasp the red block"] * 6


def test_the_key_is_nowhere_in_the_policy(policy, tmp_path):
    policy.save_pretrained(tmp_path)
    assert KEY not in (tmp_path / "config.json").read_text() + repr(policy) + repr(policy.config) + repr(vars(policy))
    assert json.loads((tmp_path / "config.json").read_text())["chat"]["api_key_env"] == "OPENAI_API_KEY"


def test_training_is_refused_in_one_sentence(policy, batch):
    for attempt in (policy.get_optim_params, lambda: policy.forward(batch)):
        with pytest.raises(ValueError, match=r"got backend=chat, which only asks a hosted model; use backend=local"):
            attempt()


def test_the_request_holds_the_task_and_the_history_of_each_row(server, policy, batch):
    policy.config.chat.max_parallel = 1
    policy.train()
    policy.next_instructions(batch)
    asked = [request["messages"][-1]["content"][-1]["text"] for request in server.requests]
    for text, task, previous in zip(asked, batch[schema.TASK], batch[schema.PREVIOUS_INSTRUCTION], strict=True):
        assert text.startswith(f"Task: {task}, please") and text.endswith(previous or "none.")
    assert policy.training


def test_a_composed_policy_acts_and_keeps_the_last_instruction_when_the_server_fails(
    server, reply, chat_config, observation, tmp_path
):
    torch.manual_seed(0)
    LlakeyCommandPolicy(chat_config).save_pretrained(tmp_path / "chat")
    hierarchy = LlakeyPolicy(LlakeyConfig(action=small_config(), commander="task", device="cpu", push_to_hub=False))
    hierarchy.action.save_pretrained(tmp_path / "action")
    named = LlakeyCommandConfig(backend="chat", model="tiny", base_url=server.url, device="cpu", cameras=["front"])
    policy = compose(tmp_path / "chat", tmp_path / "action", tmp_path / "llakey", command=named)
    policy.config.command.chat.max_parallel = 1
    policy.command.chat.settings.max_parallel = 1
    assert policy.select_action(observation).shape == (2, 9)
    assert policy.last_instructions == ["grasp the red block"] * 2
    server.script = [reply(500, "{}", AT_ONCE)]
    policy.select_action(observation)
    assert policy.last_instructions == ["grasp the red block"] * 2
    assert policy.command.chat.counts.unanswered == {"status 500": 2}
    assert [row.unparsable for row in policy.supervisors] == [1, 1]
    server.script = [reply()]
    config = LlakeyConfig.from_pretrained(tmp_path / "llakey", cli_overrides=[f"--command.base_url={server.url}"])
    loaded = LlakeyPolicy.from_pretrained(tmp_path / "llakey", config=config)
    loaded.select_action(observation)
    assert loaded.last_instructions == ["grasp the red block"] * 2


def test_a_chat_model_takes_the_place_of_a_checkpoints_command_policy(
    server, small_settings, chat_settings, observation, tmp_path
):
    torch.manual_seed(0)
    command = LlakeyCommandConfig(**small_settings)
    config = LlakeyConfig(command=command, action=small_config(), device="cpu", push_to_hub=False)
    whole = LlakeyPolicy(config)
    save(whole, tmp_path)
    flags = [f"--command.{name}={chat_settings[name]}" for name in ("backend", "base_url", "model")]
    loaded = LlakeyPolicy.from_pretrained(tmp_path, config=LlakeyConfig.from_pretrained(tmp_path, cli_overrides=flags))
    loaded.select_action(observation)
    assert loaded.last_instructions == ["grasp the red block"] * 2
    weights = whole.action.state_dict()
    assert all(torch.equal(value, weights[name]) for name, value in loaded.action.state_dict().items())
