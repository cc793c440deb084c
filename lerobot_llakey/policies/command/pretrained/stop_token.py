"""Teaches a pretrained model the paper's stop token."""

from __future__ import annotations

from typing import Any

from transformers import PreTrainedModel

from lerobot_llakey.policies.command.generation import end_answers_with
from lerobot_llakey.policies.command.prompt import STOP


def add_stop_token(model: PreTrainedModel, processor: Any) -> None:
    """Make the stop token one token of the tokenizer, with an embedding, and the end of generation."""
    tokenizer = processor.tokenizer
    tokenizer.add_special_tokens({"additional_special_tokens": [STOP]}, replace_extra_special_tokens=False)
    embeddings: Any = model.get_input_embeddings()
    if len(tokenizer) > embeddings.num_embeddings:
        model.resize_token_embeddings(len(tokenizer))
    if tokenizer.pad_token_id is None:
        tokenizer.pad_token = tokenizer.eos_token or STOP
    end_answers_with(model, tokenizer.convert_tokens_to_ids(STOP), tokenizer.pad_token_id)
