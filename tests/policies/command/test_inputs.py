import numpy as np
import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.inputs import augment, read_prompts, resize, stack_cameras


def test_images_come_in_the_order_of_the_keys():
    batch = {f"observation.images.{name}": torch.full((2, 3, 8, 8), value) for name, value in (("a", 0.1), ("b", 0.9))}
    stacked = stack_cameras(batch, ["observation.images.b", "observation.images.a"])
    assert stacked.shape == (2, 2, 3, 8, 8)
    assert stacked[0, :, 0, 0, 0].tolist() == pytest.approx([0.9, 0.1])


def test_an_image_of_another_size_is_resized_to_the_first():
    batch = {"observation.images.a": torch.zeros(1, 3, 8, 8), "observation.images.b": torch.ones(1, 3, 16, 16)}
    assert stack_cameras(batch, list(batch)).shape == (1, 2, 3, 8, 8)


def test_a_missing_image_and_a_wrong_shape_are_named():
    with pytest.raises(ValueError, match=r"add observation\.images\.b"):
        stack_cameras(
            {"observation.images.a": torch.zeros(1, 3, 8, 8)}, ["observation.images.a", "observation.images.b"]
        )
    with pytest.raises(ValueError, match=r"observation.images.a of shape \(batch, 3, height, width\), got \(3, 8, 8\)"):
        stack_cameras({"observation.images.a": torch.zeros(3, 8, 8)}, ["observation.images.a"])


def test_shift_moves_a_dot_by_no_more_than_asked():
    images = torch.zeros(16, 2, 3, 17, 17)
    images[..., 8, 8] = 1.0
    shifted = augment(images, shift=3, jitter=0.0)
    positions = shifted[:, :, 0].flatten(0, 1).flatten(1).argmax(1)
    offsets = torch.stack((positions // 17 - 8, positions % 17 - 8))
    assert offsets.abs().max() <= 3
    assert len(offsets.unique(dim=1).T) > 5
    assert torch.equal(shifted.sum((-1, -2)), images.sum((-1, -2)))


def test_jitter_changes_all_views_of_a_sample_alike_and_samples_apart():
    images = torch.full((4, 2, 3, 4, 4), 0.4)
    changed = augment(images, shift=0, jitter=0.2)
    assert torch.allclose(changed[:, 0], changed[:, 1])
    assert changed[:, 0, 0, 0, 0].unique().numel() == 4
    assert (changed - images).abs().max() <= 0.2


def test_nothing_changes_when_both_are_off():
    images = torch.rand(2, 1, 3, 8, 8)
    assert torch.equal(augment(images, 0, 0.0), images)


def test_resize():
    assert resize(torch.rand(2, 3, 8, 12), (4, 4)).shape == (2, 3, 4, 4)


def config(**settings) -> LlakeyCommandConfig:
    return LlakeyCommandConfig(
        device="cpu",
        cameras=["front"],
        state_names=list(schema.SIM_STATE_NAMES),
        workspace=[list(bounds) for bounds in schema.WORKSPACE],
        **settings,
    )


def test_the_settings_decide_what_the_prompt_contains(batch):
    previous = batch[schema.PREVIOUS_INSTRUCTION]
    assert [prompt.previous for prompt in read_prompts(batch, config())] == previous
    assert {prompt.state for prompt in read_prompts(batch, config())} == {None}
    plain = read_prompts(batch, config(history=0))
    assert [(prompt.task, prompt.previous) for prompt in plain] == [(task, None) for task in batch[schema.TASK]]


def test_the_hand_is_in_the_prompt_as_numbers(batch):
    states = batch[schema.STATE].clone()
    states[:, schema.GRIPPER] = 0.5
    texts = [
        prompt.state.split() for prompt in read_prompts(batch | {schema.STATE: states}, config(proprioception="pose"))
    ]
    assert {len(numbers) for numbers in texts} == {8} and {numbers[-1] for numbers in texts} == {"128"}
    states[0, 0] += 0.1
    moved = read_prompts(batch | {schema.STATE: states}, config(proprioception="pose"))
    assert int(moved[0].state.split()[0]) - int(texts[0][0]) in (25, 26)
    assert [prompt.state.split() for prompt in moved[1:]] == texts[1:]


def test_a_chat_model_gets_no_numbers(batch):
    settings = config(proprioception="pose", backend="chat", model="any", base_url="http://127.0.0.1:9/v1")
    assert {prompt.state for prompt in read_prompts(batch, settings)} == {None}


def test_a_missing_state_is_named(batch):
    without = {key: value for key, value in batch.items() if key != schema.STATE}
    read_prompts(without, config())
    with pytest.raises(ValueError, match=r"observation\.state.*proprioception=pose"):
        read_prompts(without, config(proprioception="pose"))


def test_the_previous_instruction_is_hidden_in_that_share_of_training(batch):
    many = {schema.TASK: ["x"] * 2000, schema.PREVIOUS_INSTRUCTION: ["grasp the cup"] * 2000}
    texts = read_prompts(many, config(history_dropout=0.3), np.random.default_rng(0))
    assert 0.25 < np.mean([prompt.previous == "" for prompt in texts]) < 0.35
