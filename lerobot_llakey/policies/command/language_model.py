"""Builds the language model chosen by the settings: the small one from scratch, or a pretrained one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.encoding import Encoder
from lerobot_llakey.policies.command.pose_text import PoseText
from lerobot_llakey.policies.command.pretrained.encoder import ProcessorEncoder
from lerobot_llakey.policies.command.pretrained.loading import build_from_assets, load_pretrained, train_parts
from lerobot_llakey.policies.command.prompt import sentences
from lerobot_llakey.policies.command.small.model import build_small, init_number_embeddings
from lerobot_llakey.policies.command.small.tokenizer import WordEncoder, WordTokenizer, grammar_words


@dataclass
class LanguageModel:
    """A model and the encoder of its inputs.

    Attributes:
        model: an image-text model of transformers.
        encoder: turns images, prompts and answers into its inputs.
        processor: a pretrained model's processor, which is saved with it; None for the small one.
    """

    model: Any
    encoder: Encoder
    processor: Any = None


def build_language_model(config: LlakeyCommandConfig, assets_dir: str | Path | None = None) -> LanguageModel:
    """Build the model, with the parts frozen that the settings do not train.

    Args:
        config: the settings, with the words of the dataset filled in.
        assets_dir: folder of a saved pretrained model's architecture and processor; its weights come later.

    Raises:
        LlakeyError: if the model cannot be found or has no part that the settings name.
    """
    if config.model is None:
        # Without a dataset's words, the grammar's and bytes still encode every text.
        has_numbers = config.target == "action" or config.uses_proprioception
        numbers = PoseText(config.action_bins, config.box).numbers if has_numbers else []
        known = list(dict.fromkeys([*(config.words or grammar_words(config.rules)), *numbers]))
        tokenizer = WordTokenizer(known, sentences(config.cameras, config.uses_proprioception))
        image_tokens = (config.image_size // config.patch_size) ** 2
        words = WordEncoder(tokenizer, config.image_size, image_tokens)
        small = build_small(config, tokenizer)
        if config.uses_proprioception:
            init_number_embeddings(small.get_input_embeddings(), [tokenizer.encode(number)[0] for number in numbers])
        built = LanguageModel(small, words)
    else:
        if assets_dir is None:
            model, processor = load_pretrained(config.model, config.weights_dtype, config.quantize)
        else:
            model, processor = build_from_assets(Path(assets_dir), config.weights_dtype)
        encoder = ProcessorEncoder(processor, config.prompt_format, config.processor_settings)
        built = LanguageModel(model, encoder, processor)
    if not config.quantize:
        built.model.to(getattr(torch, config.weights_dtype))
    train_parts(built.model, config.trained_parts)
    if config.gradient_checkpointing:
        # The reentrant kind loses the gradients of trained layers before a frozen one.
        built.model.gradient_checkpointing_enable(gradient_checkpointing_kwargs={"use_reentrant": False})
    return built
