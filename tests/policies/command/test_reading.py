import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.reading import read_prompts


def config(**settings) -> LlakeyCommandConfig:
    return LlakeyCommandConfig(
        device="cpu",
        cameras=["front"],
        state_names=list(schema.SIM_STATE_NAMES),
        workspace=[list(bounds) for bounds in schema.WORKSPACE],
        **settings,
    )


def test_only_what_the_settings_say_is_told(batch):
    previous = batch[schema.PREVIOUS_INSTRUCTION]
    assert [prompt.previous for prompt in read_prompts(batch, config())] == previous
    assert {prompt.state for prompt in read_prompts(batch, config())} == {None}
    plain = read_prompts(batch, config(history=0))
    assert [(prompt.task, prompt.previous) for prompt in plain] == [(task, None) for task in batch[schema.TASK]]


def test_the_state_is_told_in_numbers_that_follow_the_hand(batch):
    states = batch[schema.STATE].clone()
    states[:, schema.GRIPPER] = 0.5
    told = [
        prompt.state.split() for prompt in read_prompts(batch | {schema.STATE: states}, config(proprioception="pose"))
    ]
    assert {len(numbers) for numbers in told} == {8} and {numbers[-1] for numbers in told} == {"128"}
    states[0, 0] += 0.1
    moved = read_prompts(batch | {schema.STATE: states}, config(proprioception="pose"))
    assert int(moved[0].state.split()[0]) - int(told[0][0]) in (25, 26)
    assert [prompt.state.split() for prompt in moved[1:]] == told[1:]


def test_a_chat_model_is_told_no_numbers(batch):
    settings = config(proprioception="pose", backend="chat", model="any", base_url="http://127.0.0.1:9/v1")
    assert {prompt.state for prompt in read_prompts(batch, settings)} == {None}


def test_a_missing_state_is_named(batch):
    without = {key: value for key, value in batch.items() if key != schema.STATE}
    read_prompts(without, config())
    with pytest.raises(ValueError, match=r"observation\.state.*proprioception=pose"):
        read_prompts(without, config(proprioception="pose"))


def test_the_previous_instruction_is_hidden_in_that_share_of_training(batch):
    many = {schema.TASK: ["x"] * 2000, schema.PREVIOUS_INSTRUCTION: ["grasp the cup"] * 2000}
    told = read_prompts(many, config(history_dropout=0.3), np.random.default_rng(0))
    assert 0.25 < np.mean([prompt.previous == "" for prompt in told]) < 0.35
