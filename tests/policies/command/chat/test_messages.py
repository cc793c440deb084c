import base64
import io

import numpy as np
import pytest
import torch
from PIL import Image

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.grammar_data import LONGEST
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.command.chat import messages
from lerobot_llakey.policies.command.chat.messages import (
    Example,
    data_url,
    draw_examples,
    first_instruction,
    question,
    solved,
    spread,
    system_message,
)
from lerobot_llakey.policies.command.chat.settings import ChatSettings
from lerobot_llakey.policies.command.prompt import SYSTEM_MESSAGE, Prompt

CAMERAS = ("wrist", "front")
PROMPT = Prompt(("front", "wrist"), "open the drawer", "raise the robotic arm")


def _pixels(url: str) -> np.ndarray:
    head, _, data = url.partition(",")
    assert head in ("data:image/png;base64", "data:image/jpeg;base64")
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(data))))


def test_png_keeps_every_pixel_and_jpeg_nearly():
    values = torch.randint(0, 256, (3, 1, 8)).repeat_interleave(8, 1).repeat_interleave(4, 2)
    shown = values.permute(1, 2, 0).numpy()
    assert np.array_equal(_pixels(data_url(values / 255)), shown)
    smooth = torch.linspace(0, 1, 16)[None, :, None].expand(3, 16, 16)
    assert np.abs(_pixels(data_url(smooth, "jpeg"))[..., 0] / 255 - smooth[0].numpy()).max() < 0.02


def test_each_description_is_followed_by_its_image_and_the_request_comes_last():
    images = torch.stack((torch.zeros(3, 8, 8), torch.ones(3, 8, 8)))
    message = question(PROMPT, images)
    texts = [part.get("text") for part in message["content"]]
    assert message["role"] == "user"
    assert texts[0::2] == [
        "Image in front of the robotic arm:",
        "Image from the wrist of the robotic arm:",
        "Task: open the drawer, please instruct the robotic arm's next action based on the current images. "
        "Previous instruction: raise the robotic arm",
    ]
    shown = [_pixels(part["image_url"]["url"]).mean() for part in message["content"][1::2]]
    assert shown == [0, 255]
    with pytest.raises(ValueError, match="shorter"):
        question(PROMPT, images[:1])


def test_the_system_message_is_the_papers_alone_without_guidance():
    assert system_message(PROMPT) == {"role": "system", "content": SYSTEM_MESSAGE}
    assert system_message(PROMPT, "Be brief.")["content"] == f"{SYSTEM_MESSAGE}\nBe brief."


def test_examples_become_a_conversation():
    images = torch.rand(2, 3, 8, 8)
    conversation = solved([Example(PROMPT, images, "grasp the handle")] * 2)
    assert conversation == [question(PROMPT, images), {"role": "assistant", "content": "grasp the handle"}] * 2


def _settings(dataset, count: int, seed: int = 0) -> ChatSettings:
    return ChatSettings(
        examples=count, examples_repo_id=dataset.repo_id, examples_root=str(dataset.root), examples_seed=seed
    )


def test_examples_are_samples_of_the_dataset_in_the_prompts_form(keysteps):
    examples = draw_examples(_settings(keysteps, 4), CAMERAS, history=True)
    assert len({example.answer for example in examples}) == 4  # as many as there are
    samples = [keysteps[index] for index in range(len(keysteps))]
    for example in examples:
        keys = [schema.image_key(camera) for camera in CAMERAS]
        matches = [
            sample
            for sample in samples
            if sample[schema.INSTRUCTION] == example.answer
            and torch.equal(torch.stack([sample[key] for key in keys]), example.images)
            and (sample[schema.TASK], sample[schema.PREVIOUS_INSTRUCTION])
            == (example.prompt.task, example.prompt.previous)
        ]
        assert matches and example.prompt.cameras == CAMERAS


def test_the_seed_decides_which_and_history_is_left_out_where_it_is_off(keysteps):
    first, again, other = (draw_examples(_settings(keysteps, 3, seed), CAMERAS, history=False) for seed in (0, 0, 1))
    assert [example.answer for example in first] == [example.answer for example in again]
    assert all(torch.equal(a.images, b.images) for a, b in zip(first, again, strict=True))
    assert [example.answer for example in first] != [example.answer for example in other]
    assert {example.prompt.previous for example in first} == {None}
    assert draw_examples(ChatSettings(), CAMERAS, history=True) == []


def test_no_label_comes_twice_before_all_came_once():
    labels = ["a"] * 10 + ["b"] * 2 + ["c"]
    drawn = [labels[index] for index in spread(labels, 6, np.random.default_rng(0))]
    assert sorted(drawn[:3]) == ["a", "b", "c"] and sorted(drawn[3:5]) == ["a", "b"] and drawn[5] == "a"


def test_datasets_that_do_not_serve_are_named(keysteps, tmp_path):
    with pytest.raises(ValueError, match="at least 99 samples"):
        draw_examples(_settings(keysteps, 99), CAMERAS, history=True)
    with pytest.raises(ValueError, match=r"add observation\.images\.elbow"):
        draw_examples(_settings(keysteps, 1), ("elbow",), history=True)
    bare = fake_keysteps(tmp_path / "bare", episodes=1, image_size=16, without=(schema.INSTRUCTION,))
    with pytest.raises(ValueError, match=r"with the column 'instruction'"):
        draw_examples(_settings(bare, 1), CAMERAS, history=True)


@pytest.mark.parametrize(
    "written",
    [
        "grasp the red block",
        "grasp the red block <next goal> release the red block",
        '"grasp the red block."',
        '"grasp the red block".',
        "**grasp the red block**",
        "\n\n- `grasp the red block`\n- release the red block",
        "1. grasp the red block\n2. raise the robotic arm",
        "Answer: grasp the red block",
        "**Next action:** \u201cgrasp the red block\u201d",
        "Sure! The next action is:\n\n**grasp the red block**\nGood luck!",
        "```\ngrasp the red block\n```",
        "<think>release the red block?\nno</think>\ngrasp the red block",
    ],
)
def test_the_first_basic_action_is_found(written):
    assert first_instruction(written, BASIC_GRAMMAR) == "grasp the red block"


@pytest.mark.parametrize(
    ("written", "left"),
    [
        ("I cannot tell.\nSorry.", "I cannot tell"),
        ("", ""),
        (" \n<next goal>grasp the red block", ""),
        ("<think>grasp the red block", ""),
        ("```", ""),
        ("open the drawer and then grasp the red block", "open the drawer and then grasp the red block"),
    ],
)
def test_other_words_stay_as_they_are(written, left):
    assert first_instruction(written, BASIC_GRAMMAR) == left
    assert not BASIC_GRAMMAR.is_parsable(left)


@pytest.mark.parametrize("written", ["1. " * 400_000, "rotate the " + "a to the " * 50_000, "1. " * 99 + "\n" * 9999])
def test_of_a_long_answer_a_short_line_is_left(written, monkeypatch):
    looked_at = []
    monkeypatch.setattr(messages, "_bare", lambda line: looked_at.append(line) or line)
    assert len(first_instruction(written, BASIC_GRAMMAR)) <= 2 * LONGEST
    assert len(looked_at) == 1 and len(looked_at[0]) <= 2 * LONGEST


def test_of_many_lines_the_first_are_looked_at(monkeypatch):
    looked_at = []
    monkeypatch.setattr(messages, "_bare", lambda line: looked_at.append(line) or line)
    assert first_instruction("hm\n" * 100_000 + "grasp the red block", BASIC_GRAMMAR) == "hm"
    assert len(looked_at) == 200
