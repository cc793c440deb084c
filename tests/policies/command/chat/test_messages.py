import base64
import io

import numpy as np
import pytest
import torch
from PIL import Image

from lerobot_llakey.policies.command.chat.messages import Example, data_url, question, solved, system_message
from lerobot_llakey.policies.command.prompt import SYSTEM_MESSAGE, Prompt

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


def test_examples_are_turns_of_a_conversation():
    images = torch.rand(2, 3, 8, 8)
    turns = solved([Example(PROMPT, images, "grasp the handle")] * 2)
    assert turns == [question(PROMPT, images), {"role": "assistant", "content": "grasp the handle"}] * 2
