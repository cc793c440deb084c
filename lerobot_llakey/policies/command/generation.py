"""How answers are generated: greedily, up to the stop token."""

from __future__ import annotations

from transformers import PreTrainedModel


def end_answers_with(model: PreTrainedModel, stop_id: int, pad_id: int) -> None:
    """Make generation greedy and end it with the stop token."""
    assert model.generation_config is not None
    model.generation_config.eos_token_id = stop_id
    model.generation_config.pad_token_id = pad_id
    model.generation_config.do_sample = False
    model.generation_config.temperature = None
    model.generation_config.top_p = None
