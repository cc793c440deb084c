"""Encodes for the small model: words, constant sentences as single tokens, images in -1..1."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import torch
from torch import Tensor

from lerobot_llakey.policies.command.encoding import Encoder
from lerobot_llakey.policies.command.images import resize
from lerobot_llakey.policies.command.prompt import Prompt
from lerobot_llakey.policies.command.small.tokenizer import WordTokenizer


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
