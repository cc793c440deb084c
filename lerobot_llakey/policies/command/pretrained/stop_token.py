"""Teaches a pretrained model the paper's stop token."""

from __future__ import annotations

from typing import Any

import torch
from transformers import PreTrainedModel

from lerobot_llakey.policies.command.encoding import end_answers_with
from lerobot_llakey.policies.command.prompt import STOP


def add_stop_token(model: PreTrainedModel, processor: Any) -> None:
    """Make the stop token one token of the tokenizer, with an embedding, and the end of generation.

    A new token starts as the mean of the others, in the embedding and in the output layer, so that every process and
    every later run that loads the same model gets the same weights: an adapter is saved without them.
    """
    tokenizer = processor.tokenizer
    is_new = STOP not in tokenizer.get_vocab()
    tokenizer.add_special_tokens({"additional_special_tokens": [STOP]}, replace_extra_special_tokens=False)
    stop_id = tokenizer.convert_tokens_to_ids(STOP)
    embeddings: Any = model.get_input_embeddings()
    known = min(embeddings.num_embeddings, stop_id)
    if len(tokenizer) > embeddings.num_embeddings:
        model.resize_token_embeddings(len(tokenizer), mean_resizing=False)
    if is_new:
        _start_as_mean(model, stop_id, known)
    if tokenizer.pad_token_id is None:
        tokenizer.pad_token = tokenizer.eos_token or STOP
    end_answers_with(model, stop_id, tokenizer.pad_token_id)


@torch.no_grad()
def _start_as_mean(model: PreTrainedModel, stop_id: int, known: int) -> None:
    layers: list[Any] = [model.get_input_embeddings(), model.get_output_embeddings()]
    for layer in layers:
        if layer is not None and layer.weight.device.type != "meta":
            layer.weight[known:] = layer.weight[:known].float().mean(0).to(layer.weight.dtype)
