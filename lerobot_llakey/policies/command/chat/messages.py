"""Messages of the chat-completions API: prompts, solved examples, and the instruction in an answer."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from PIL import Image
from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.grammar_data import LONGEST
from lerobot_llakey.policies.command.chat.settings import ChatSettings
from lerobot_llakey.policies.command.inputs import stack_cameras
from lerobot_llakey.policies.command.prompt import STOP, Prompt

Message = dict[str, Any]

_THOUGHTS = re.compile(r"<think>.*?(</think>|\Z)", re.DOTALL)
_MARKDOWN = re.compile(r"^(?:[-*+>#]+\s|\d+[.)]\s)\s*")
_LABEL = re.compile(r"^(?:answer|instruction|action|next (?:basic )?(?:action|instruction))\s*:\s*", re.IGNORECASE)
_LONGEST_LINE, _MOST_LINES = 2 * LONGEST, 200
"""Limits on what is read of a long answer: a basic action is short, and little text precedes it."""
_WRAPPING = " \t\"'`*_\u201c\u201d\u2018\u2019"


@dataclass(frozen=True)
class Example:
    """A solved question.

    Attributes:
        prompt: the question.
        images: (V, 3, H, W) in 0..1, one for each of its cameras.
        answer: the correct instruction.
    """

    prompt: Prompt
    images: Tensor
    answer: str


def data_url(image: Tensor, image_format: str = "png") -> str:
    """An image (3, H, W) in 0..1 as a data URL of 8 bits a channel; "png" is lossless, "jpeg" is not."""
    pixels = (image.detach().float().clamp(0, 1) * 255).round().byte().permute(1, 2, 0).cpu().numpy()
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format=image_format, **({"quality": 95} if image_format == "jpeg" else {}))
    return f"data:image/{image_format};base64,{base64.b64encode(buffer.getvalue()).decode()}"


def system_message(prompt: Prompt, guidance: str = "") -> Message:
    """The prompt's opening, followed by the guidance about answers, in the system's role."""
    return {"role": "system", "content": f"{prompt.opening}\n{guidance}" if guidance else prompt.opening}


def question(prompt: Prompt, images: Tensor, image_format: str = "png") -> Message:
    """Each camera's description followed by its image (V, 3, H, W in 0..1), then the request, in the user's role."""
    content: list[dict[str, Any]] = []
    for description, image in zip(prompt.descriptions, images, strict=True):
        content.append({"type": "text", "text": description})
        content.append({"type": "image_url", "image_url": {"url": data_url(image, image_format)}})
    return {"role": "user", "content": [*content, {"type": "text", "text": prompt.request_text}]}


def solved(examples: Sequence[Example], image_format: str = "png") -> list[Message]:
    """Examples as a conversation: question, answer, question, answer..."""
    messages: list[Message] = []
    for example in examples:
        messages.append(question(example.prompt, example.images, image_format))
        messages.append({"role": "assistant", "content": example.answer})
    return messages


def draw_examples(settings: ChatSettings, cameras: Sequence[str], history: bool) -> list[Example]:
    """Draw solved examples, evenly over the dataset's different instructions; the same seed draws the same ones.

    Args:
        settings: how many, from which dataset, and the seed.
        cameras: names of the cameras, in the order of the prompt.
        history: whether the prompt contains the instruction last commanded.

    Raises:
        LlakeyError: if the dataset is too small, or lacks the instructions or a camera.
    """
    if not settings.examples:
        return []
    dataset = LeRobotDataset(str(settings.examples_repo_id), root=settings.examples_root)
    if schema.INSTRUCTION not in dataset.features:
        raise LlakeyError(
            f"Expected `chat.examples_repo_id` to name a dataset with the column {schema.INSTRUCTION!r}, got "
            f"{settings.examples_repo_id!r} without it; make one with `llakey keysteps`."
        )
    if len(dataset) < settings.examples:
        raise LlakeyError(
            f"Expected at least {settings.examples} samples in {settings.examples_repo_id!r}, got {len(dataset)}; "
            "lower chat.examples or give a larger dataset."
        )
    instructions = [str(text) for text in dataset.hf_dataset.with_format(None)[schema.INSTRUCTION]]
    rows = spread(instructions, settings.examples, np.random.default_rng(settings.examples_seed))
    return [_example(dataset[row], cameras, history) for row in rows]


def spread(labels: Sequence[str], count: int, rng: np.random.Generator) -> list[int]:
    """Indices of ``count`` labels in random order; no label repeats before every label has appeared."""
    order = rng.permutation(len(labels)).tolist()
    repeats: dict[str, int] = {}
    round_of = {}
    for index in order:
        round_of[index] = repeats[labels[index]] = repeats.get(labels[index], -1) + 1
    return sorted(order, key=round_of.__getitem__)[:count]


def _example(sample: dict[str, Any], cameras: Sequence[str], history: bool) -> Example:
    keys = [schema.image_key(camera) for camera in cameras]
    images = stack_cameras({key: sample[key][None] for key in keys if key in sample}, keys)[0]
    previous = str(sample.get(schema.PREVIOUS_INSTRUCTION, "")) if history else None
    return Example(Prompt(tuple(cameras), str(sample[schema.TASK]), previous), images, str(sample[schema.INSTRUCTION]))


def first_instruction(text: str, grammar: Grammar) -> str:
    """The first line before the stop token that is a basic action, else the first line with any words.

    Quotes, Markdown, numbering, a label such as "Answer:" and the thoughts of a reasoning model are removed.

    Args:
        text: the model's whole output.
        grammar: of the answers.

    Returns:
        One line, which need not be in the grammar; "" if the output has no words. Long lines are cut, and only the
        first ``_MOST_LINES`` lines are read.
    """
    written = filter(str.strip, _THOUGHTS.sub("", text).partition(STOP)[0].splitlines())
    lines = list(filter(None, (_bare(line.strip()[:_LONGEST_LINE]) for line in islice(written, _MOST_LINES))))
    return next(filter(grammar.is_parsable, lines), lines[0] if lines else "")


def _bare(line: str) -> str:
    """A line without labels, quotes and Markdown."""
    before = None
    while line != before:
        before = line
        line = _LABEL.sub("", _MARKDOWN.sub("", line.strip().strip(_WRAPPING)))
        # A full stop may stand inside or outside of quotes.
        line = line[:-1] if line.endswith((".", ",")) else line
    return "" if line.startswith("```") else line
