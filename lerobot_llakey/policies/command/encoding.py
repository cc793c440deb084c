"""Turns images, prompts and answers into a model's inputs: one encoder for the small model, one for pretrained ones."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import Any

import torch
from torch import Tensor

from lerobot_llakey.policies.command.images import resize
from lerobot_llakey.policies.command.prompt import STOP, Prompt
from lerobot_llakey.policies.command.tokenizer import WordTokenizer

IGNORED = -100
"""Label of a token that no loss is taken on."""


class Encoder(ABC):
    """What the policy needs of a model's tokenizer and image processor."""

    pad_id: int
    stop_id: int

    @abstractmethod
    def prompts(self, images: Tensor, prompts: Sequence[Prompt]) -> dict[str, Tensor]:
        """Inputs of a model from images (B, V, 3, H, W) in 0..1.

        Returns:
            ``input_ids`` and ``attention_mask`` (B, T), padded on the left, and what the model takes for images.
        """

    @abstractmethod
    def answer(self, text: str) -> list[int]:
        """Token ids of an answer, ending with the stop token."""

    @abstractmethod
    def decode(self, ids: Iterable[int]) -> str:
        """The text of generated ids up to the stop token."""

    def with_answers(
        self, images: Tensor, prompts: Sequence[Prompt], answers: Sequence[str]
    ) -> tuple[dict[str, Tensor], Tensor]:
        """Inputs for training.

        Returns:
            The inputs, answers appended, and the answers' labels (B, A), where A is the longest answer: the model's
            last A + 1 positions but the final one predict them. Padding is labelled ``IGNORED``.
        """
        inputs = self.prompts(images, prompts)
        device = inputs["input_ids"].device
        rows = [self.answer(text) for text in answers]
        longest = max(map(len, rows))
        ids = torch.tensor([row + [self.pad_id] * (longest - len(row)) for row in rows], device=device)
        real = torch.tensor([[1] * len(row) + [0] * (longest - len(row)) for row in rows], device=device)
        inputs["input_ids"] = torch.cat((inputs["input_ids"], ids), dim=1)
        inputs["attention_mask"] = torch.cat((inputs["attention_mask"], real), dim=1)
        for key in ("token_type_ids", "mm_token_type_ids"):
            if key in inputs:
                inputs[key] = torch.cat((inputs[key], torch.zeros_like(ids)), dim=1)
        return inputs, torch.where(real.bool(), ids, IGNORED)


class WordEncoder(Encoder):
    """Encoder of the small model: words, constant sentences as single tokens, images in -1..1.

    Args:
        tokenizer: the small tokenizer.
        image_size: pixels a side.
        image_tokens: tokens an image takes.
    """

    def __init__(self, tokenizer: WordTokenizer, image_size: int, image_tokens: int) -> None:
        self.tokenizer = tokenizer
        self.image_size = image_size
        self.image_tokens = image_tokens
        self.pad_id, self.stop_id = tokenizer.pad_id, tokenizer.stop_id

    def prompts(self, images: Tensor, prompts: Sequence[Prompt]) -> dict[str, Tensor]:
        rows = [self._ids(prompt) for prompt in prompts]
        longest = max(map(len, rows))
        ids = torch.tensor([[self.pad_id] * (longest - len(row)) + row for row in rows], device=images.device)
        pixels = images.flatten(0, 1)
        if pixels.shape[-2:] != (self.image_size, self.image_size):
            pixels = resize(pixels, (self.image_size, self.image_size))
        return {
            "input_ids": ids,
            "attention_mask": (ids != self.pad_id).long(),
            "pixel_values": pixels * 2 - 1,
        }

    def _ids(self, prompt: Prompt) -> list[int]:
        ids = [self.tokenizer.begin_id, *self.tokenizer.encode(prompt.opening)]
        for description in prompt.descriptions:
            ids += [*self.tokenizer.encode(description), *[self.tokenizer.image_id] * self.image_tokens]
        return ids + [token for piece in prompt.request for token in self.tokenizer.encode(piece)]

    def answer(self, text: str) -> list[int]:
        return [*self.tokenizer.encode(text), self.stop_id]

    def decode(self, ids: Iterable[int]) -> str:
        return self.tokenizer.decode(ids)


class ProcessorEncoder(Encoder):
    """Encoder of a pretrained model, through its own processor.

    Args:
        processor: a transformers processor of images and text, whose tokenizer knows the stop token.
        template: the conversation form, with the slots ``{system}`` and ``{request}``.
    """

    def __init__(self, processor: Any, template: str) -> None:
        self.processor = processor
        self.template = template
        self.pad_id = processor.tokenizer.pad_token_id
        self.stop_id = processor.tokenizer.convert_tokens_to_ids(STOP)
        self._image_token = getattr(processor, "image_token", "<image>")

    def prompts(self, images: Tensor, prompts: Sequence[Prompt]) -> dict[str, Tensor]:
        pixels = (images * 255).round().to(torch.uint8).cpu()
        inputs = self.processor(
            text=[prompt.text(self._image_token, self.template) for prompt in prompts],
            images=[list(row) for row in pixels],
            return_tensors="pt",
            padding=True,
            padding_side="left",
        )
        return {key: value.to(images.device) for key, value in inputs.items()}

    def answer(self, text: str) -> list[int]:
        # A leading space keeps the first word in the form that it has in running text.
        return [*self.processor.tokenizer.encode(f" {text}", add_special_tokens=False), self.stop_id]

    def decode(self, ids: Iterable[int]) -> str:
        kept: list[int] = []
        for token in ids:
            if token == self.stop_id:
                break
            kept.append(token)
        return " ".join(self.processor.tokenizer.decode(kept, skip_special_tokens=True).split())
