"""Encodes for a pretrained model, through its own processor."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import torch
from torch import Tensor

from lerobot_llakey.policies.command.encoding import Encoder
from lerobot_llakey.policies.command.prompt import STOP, Prompt


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
