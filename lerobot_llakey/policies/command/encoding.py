"""The interface between the policy and a model's tokenizer and image processor."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence

import torch
from torch import Tensor
from transformers import PreTrainedModel

from lerobot_llakey.policies.command.prompt import Prompt

IGNORED = -100
"""Label of a token without a loss."""


class Encoder(ABC):
    """Turns images, prompts and answers into a model's inputs, and token ids back into text."""

    pad_id: int
    stop_id: int
    answer_type_id: int = 0
    """Type of an answer's tokens, for models with token types."""

    @abstractmethod
    def prompts(self, images: Tensor, prompts: Sequence[Prompt]) -> dict[str, Tensor]:
        """Inputs of a model from images (B, V, 3, H, W) in 0..1.

        Returns:
            ``input_ids`` and ``attention_mask`` (B, T), padded on the left, and the model's image inputs.
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
            The inputs with the answers appended, and the answers' labels (B, A), A being the longest answer: the
            model's last A + 1 positions except the final one predict them. Padding is labelled ``IGNORED``.
        """
        inputs = self.prompts(images, prompts)
        device = inputs["input_ids"].device
        rows = [self.answer(text) for text in answers]
        longest = max(map(len, rows))
        ids = torch.tensor([row + [self.pad_id] * (longest - len(row)) for row in rows], device=device)
        real = torch.tensor([[1] * len(row) + [0] * (longest - len(row)) for row in rows], device=device)
        inputs["input_ids"] = torch.cat((inputs["input_ids"], ids), dim=1)
        inputs["attention_mask"] = torch.cat((inputs["attention_mask"], real), dim=1)
        for key, kind in (("token_type_ids", self.answer_type_id), ("mm_token_type_ids", 0)):
            if key in inputs:
                inputs[key] = torch.cat((inputs[key], real * kind), dim=1)
        return inputs, torch.where(real.bool(), ids, IGNORED)


def end_answers_with(model: PreTrainedModel, stop_id: int, pad_id: int) -> None:
    """Make a model's generation greedy and end it at the stop token."""
    assert model.generation_config is not None
    model.generation_config.eos_token_id = stop_id
    model.generation_config.pad_token_id = pad_id
    model.generation_config.do_sample = False
    model.generation_config.temperature = None
    model.generation_config.top_p = None
