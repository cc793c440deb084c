"""Builds the small LLaVA from the transformers classes."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor, nn
from transformers import CLIPVisionConfig, LlamaConfig, LlavaConfig, LlavaForConditionalGeneration

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.generation import end_answers_with
from lerobot_llakey.policies.command.small.last_layer import LastLayer
from lerobot_llakey.policies.command.small.tokenizer import WordTokenizer


class ConvolutionalStem(nn.Module):
    """Overlapping patches: a 4x4 cut followed by strided 3x3 convolutions, in place of CLIP's one large cut.

    Small networks trained on few samples see fine detail (is the finger around the lid?) sooner this way, and the
    convolutions run at a quarter of the resolution and below, where they are cheap.

    Args:
        width: channels of a patch.
        patch_size: pixels a side of a patch: 4 times a power of 2.
    """

    def __init__(self, width: int, patch_size: int) -> None:
        super().__init__()
        halvings = (patch_size // 4).bit_length() - 1
        if patch_size != 4 << halvings:
            raise LlakeyError(f"Expected `patch_size` to be 4, 8, 16 or 32 with a stem, got {patch_size}; change it.")
        channels = max(32, width >> (halvings + 1)) if halvings else width
        self.cut = nn.Conv2d(3, channels, 4, stride=4)
        layers: list[nn.Module] = []
        for index in range(halvings):
            grown = width if index == halvings - 1 else channels * 2
            layers += [nn.GroupNorm(1, channels), nn.GELU(), nn.Conv2d(channels, grown, 3, stride=2, padding=1)]
            channels = grown
        self.layers = nn.Sequential(*layers)

    @property
    def weight(self) -> Tensor:
        """CLIP's embeddings read the dtype of their input from here."""
        return self.cut.weight

    def forward(self, images: Tensor) -> Tensor:
        """Images (N, 3, H, W) to patches (N, width, H / patch, W / patch)."""
        return self.layers(self.cut(images.contiguous(memory_format=torch.channels_last)))


class ViewProjector(nn.Module):
    """The paper's linear projection of visual features, with a learned mark that tells the views apart.

    Args:
        features: channels of a visual feature.
        width: channels of the language model.
        views: number of images of one prompt; they come in that order.
    """

    def __init__(self, features: int, width: int, views: int) -> None:
        super().__init__()
        self.linear = nn.Linear(features, width)
        self.view = nn.Parameter(torch.randn(views, 1, width) * 0.02)

    def forward(self, features: Tensor) -> Tensor:
        """Features (B * views, patches, features) to embeddings (B * views, patches, width)."""
        return self.linear(features) + self.view.repeat(len(features) // len(self.view), 1, 1)


def build_small(config: LlakeyCommandConfig, tokenizer: WordTokenizer) -> LlavaForConditionalGeneration:
    """The small LLaVA, with fresh weights.

    As in the paper, the features before and after the vision tower's last layer are both projected.
    """
    vision: dict[str, Any] = {
        "hidden_size": config.vision_width,
        "intermediate_size": 4 * config.vision_width,
        "num_hidden_layers": config.vision_layers,
        "num_attention_heads": config.vision_heads,
        "image_size": config.image_size,
        "patch_size": config.patch_size,
        "hidden_act": "gelu",
        "initializer_factor": 1.0,
    }
    text: dict[str, Any] = {
        "vocab_size": len(tokenizer),
        "hidden_size": config.text_width,
        "intermediate_size": round(config.text_width * 8 / 3 / 64) * 64,
        "num_hidden_layers": config.text_layers,
        "num_attention_heads": config.text_heads,
        "max_position_embeddings": 2048,
        "pad_token_id": tokenizer.pad_id,
        "bos_token_id": tokenizer.begin_id,
        "eos_token_id": tokenizer.stop_id,
        "tie_word_embeddings": True,
    }
    layers = [-2, -1]
    llava: dict[str, Any] = {
        "vision_config": CLIPVisionConfig(**vision),
        "text_config": LlamaConfig(**text),
        "image_token_index": tokenizer.image_id,
        "image_seq_length": (config.image_size // config.patch_size) ** 2,
        "vision_feature_layer": layers,
        "projector_hidden_act": "linear",
        "tie_word_embeddings": True,
    }
    # On a CPU the fused attention's backward pass takes a third of a training step at these lengths.
    attention = "eager" if config.device == "cpu" else "sdpa"
    model = LlavaForConditionalGeneration._from_config(LlavaConfig(**llava), attn_implementation=attention)
    model.model.multi_modal_projector = ViewProjector(
        config.vision_width * len(layers), config.text_width, len(config.cameras)
    )
    layers_of_text: Any = model.model.language_model.layers
    layers_of_text[-1] = LastLayer(model.config.text_config, len(layers_of_text) - 1)
    layers_of_text[-1].apply(model._init_weights)
    embeddings = model.model.vision_tower.vision_model.embeddings
    embeddings.patch_embedding = ConvolutionalStem(config.vision_width, config.patch_size)
    end_answers_with(model, tokenizer.stop_id, tokenizer.pad_id)
    return model
