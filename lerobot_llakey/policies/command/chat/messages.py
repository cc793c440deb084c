"""Prompts and images as the messages of the chat-completions API."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from PIL import Image
from torch import Tensor

from lerobot_llakey.policies.command.prompt import Prompt

Message = dict[str, Any]


@dataclass(frozen=True)
class Example:
    """A solved question.

    Attributes:
        prompt: the question.
        images: (V, 3, H, W) in 0..1, one for each of its views.
        answer: the right instruction.
    """

    prompt: Prompt
    images: Tensor
    answer: str


def data_url(image: Tensor, image_format: str = "png") -> str:
    """An image (3, H, W) in 0..1 as a data URL.

    Args:
        image: 8 bits a channel are kept of it.
        image_format: "png", which loses nothing, or "jpeg".
    """
    pixels = (image.detach().float().clamp(0, 1) * 255).round().byte().permute(1, 2, 0).cpu().numpy()
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format=image_format, **({"quality": 95} if image_format == "jpeg" else {}))
    return f"data:image/{image_format};base64,{base64.b64encode(buffer.getvalue()).decode()}"


def system_message(prompt: Prompt, guidance: str = "") -> Message:
    """The prompt's opening, with what is said about answers after it, in the system's role."""
    return {"role": "system", "content": f"{prompt.opening}\n{guidance}" if guidance else prompt.opening}


def question(prompt: Prompt, images: Tensor, image_format: str = "png") -> Message:
    """Each view's description followed by its image, then the request, in the user's role.

    Args:
        prompt: what is asked.
        images: (V, 3, H, W) in 0..1, one for each of its views.
        image_format: see :func:`data_url`.
    """
    content: list[dict[str, Any]] = []
    for description, image in zip(prompt.descriptions, images, strict=True):
        content.append({"type": "text", "text": description})
        content.append({"type": "image_url", "image_url": {"url": data_url(image, image_format)}})
    return {"role": "user", "content": [*content, {"type": "text", "text": prompt.asked}]}


def solved(examples: Sequence[Example], image_format: str = "png") -> list[Message]:
    """Examples as turns of a conversation: question, answer, question, answer..."""
    turns: list[Message] = []
    for example in examples:
        turns.append(question(example.prompt, example.images, image_format))
        turns.append({"role": "assistant", "content": example.answer})
    return turns
