"""The small LLaVA: a network of transformers' classes with changes for training from scratch on a CPU."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional
from transformers import CLIPVisionConfig, LlamaConfig, LlavaConfig, LlavaForConditionalGeneration
from transformers.models.llama.modeling_llama import LlamaDecoderLayer, apply_rotary_pos_emb

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.encoding import end_answers_with
from lerobot_llakey.policies.command.small.tokenizer import WordTokenizer

_SPREAD = 0.02
"""Standard deviation of transformers' initial embeddings."""
UNIT_METRES = 0.2
"""Unit of regressed positions, which makes them about as large as the gripper's 0 and 1."""


class ConvolutionalStem(nn.Module):
    """Overlapping patches: a 4x4 cut followed by strided 3x3 convolutions, in place of CLIP's one large cut.

    Small networks trained on few samples learn fine detail (is the finger around the lid?) sooner with it, and the
    convolutions run at a quarter of the resolution or less, where they are cheap.

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
        """CLIP's embedding layer takes the dtype of its input from it."""
        return self.cut.weight

    def forward(self, images: Tensor) -> Tensor:
        """Images (N, 3, H, W) to patches (N, width, H / patch, W / patch)."""
        return self.layers(self.cut(images.contiguous(memory_format=torch.channels_last)))


class CameraProjector(nn.Module):
    """The paper's linear projection of visual features, plus a learned embedding for each camera.

    Args:
        features: channels of a visual feature.
        width: channels of the language model.
        cameras: number of images of one prompt, in a fixed order.
    """

    def __init__(self, features: int, width: int, cameras: int) -> None:
        super().__init__()
        self.linear = nn.Linear(features, width)
        self.view = nn.Parameter(torch.randn(cameras, 1, width) * 0.02)

    def forward(self, features: Tensor) -> Tensor:
        """Features (B * cameras, patches, features) to embeddings (B * cameras, patches, width)."""
        return self.linear(features) + self.view.repeat(len(features) // len(self.view), 1, 1)


def build_small(config: LlakeyCommandConfig, tokenizer: WordTokenizer) -> LlavaForConditionalGeneration:
    """The small LLaVA, with fresh weights.

    As in the paper, the projector takes the features before and after the vision tower's last layer.
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
    # On a CPU fused attention is slow here: its backward pass would take a third of a training step.
    attention = "eager" if config.device == "cpu" else "sdpa"
    model = LlavaForConditionalGeneration._from_config(LlavaConfig(**llava), attn_implementation=attention)
    model.model.multi_modal_projector = CameraProjector(
        config.vision_width * len(layers), config.text_width, len(config.cameras)
    )
    layers_of_text: Any = model.model.language_model.layers
    layers_of_text[-1] = LastLayer(model.config.text_config, len(layers_of_text) - 1)
    layers_of_text[-1].apply(model._init_weights)
    embeddings = model.model.vision_tower.vision_model.embeddings
    embeddings.patch_embedding = ConvolutionalStem(config.vision_width, config.patch_size)
    end_answers_with(model, tokenizer.stop_id, tokenizer.pad_id)
    return model


class LastLayer(LlamaDecoderLayer):
    """A Llama layer that can skip positions with unused outputs.

    The answer's first token depends only on the output at the last of some 300 prompt positions, and training needs
    only the outputs at the answer's. The layer computes keys and values at all positions, but queries and all that
    follows only where the output is used. Its weights have the names and shapes of the original class.
    """

    def forward(self, hidden_states: Tensor, *args: Any, keep: int | None = None, **kwargs: Any) -> Tensor:
        """Hidden states (B, T, width) to those of the last ``keep`` positions, (B, keep, width); None keeps all.

        Args:
            hidden_states: of all positions.
            *args: as transformers passes them to a layer.
            keep: number of positions to compute, counted from the end.
            **kwargs: ``attention_mask``, ``past_key_values`` and ``position_embeddings``, as transformers passes them.
        """
        if keep is None or keep >= hidden_states.shape[1]:
            return super().forward(hidden_states, *args, **kwargs)
        attention = self.self_attn
        normed, kept = self.input_layernorm(hidden_states), hidden_states[:, -keep:]
        query, key, value = (
            layer(part).unflatten(-1, (-1, attention.head_dim)).transpose(1, 2)
            for layer, part in (
                (attention.q_proj, normed[:, -keep:]),
                (attention.k_proj, normed),
                (attention.v_proj, normed),
            )
        )
        cos, sin = kwargs["position_embeddings"]
        _, key = apply_rotary_pos_emb(key, key, cos, sin)
        query, _ = apply_rotary_pos_emb(query, query, cos[:, -keep:], sin[:, -keep:])
        cache = kwargs.get("past_key_values")
        if cache is not None:
            key, value = cache.update(key, value, attention.layer_idx)
        scores = (query * attention.scaling) @ key.transpose(-1, -2)
        scores = scores + _mask(kwargs.get("attention_mask"), scores)
        attended = scores.softmax(dim=-1, dtype=torch.float32).to(value.dtype) @ value
        kept = kept + attention.o_proj(attended.transpose(1, 2).flatten(2))
        return kept + self.mlp(self.post_attention_layernorm(kept))


def read_last(model: Any, count: int) -> dict[str, int]:
    """Keyword arguments that make a model with a :class:`LastLayer` skip all but its last ``count`` positions."""
    layers = getattr(getattr(model.model, "language_model", None), "layers", [None])
    return {"keep": count} if isinstance(layers[-1], LastLayer) else {}


def _mask(given: Tensor | None, scores: Tensor) -> Tensor:
    """The mask to add to scores (B, heads, keep, T): 0 at visible positions, else the most negative number."""
    keep, total = scores.shape[-2:]
    least = torch.finfo(scores.dtype).min
    if given is None:
        return scores.new_full((keep, total), least).triu(total - keep + 1)
    rows = given[..., -keep:, :total]
    return torch.zeros_like(rows, dtype=scores.dtype).masked_fill(~rows, least) if rows.dtype == torch.bool else rows


@torch.no_grad()
def init_number_embeddings(embedding: nn.Embedding, tokens: Sequence[int]) -> None:
    """Initialise the embeddings of consecutive numbers as points on a smooth curve.

    Each of hundreds of numbers occurs in few samples; with similar embeddings, neighbours share what they learn. The
    curve is made of sine waves with periods from all numbers down to four of them.

    Args:
        embedding: (vocabulary, width); changed in place.
        tokens: the numbers' token ids, in the order of the numbers.
    """
    count, width = len(tokens), embedding.embedding_dim
    waves = torch.logspace(0, math.log10(max(count / 4, 1)), width // 2)
    angles = torch.linspace(0, 2 * math.pi, count + 1)[:count, None] * waves
    curve = torch.stack((angles.sin(), angles.cos()), dim=-1).flatten(1) * _SPREAD * math.sqrt(2)
    embedding.weight[torch.tensor(tokens), : curve.shape[1]] = curve.to(embedding.weight)


class KeyframeHead(nn.Module):
    """Auxiliary loss: regress position and gripper, now and at the next keyframe, from the answer's first hidden state.

    Answers alone teach a network geometry slowly: a dozen tokens a sample, most of them the same. These eight numbers
    draw its attention to the gripper and to the object named in the task. The head is unused after training.

    Args:
        width: channels of the language model.
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.linear = nn.Linear(width, 8)

    def loss(self, hidden: Tensor, hand: Tensor, action: Tensor) -> Tensor:
        """Smooth L1 loss of each sample (B,).

        Args:
            hidden: (B, width) output of the language model at the last token of the prompt.
            hand: (B, 8) as in the data contract.
            action: (B, 9) as in the data contract.
        """
        numbers = [
            part
            for row in (hand, action)
            for part in (row[:, schema.POSITION] / UNIT_METRES, row[:, schema.GRIPPER, None])
        ]
        target = torch.cat(numbers, dim=1).float()
        prediction = self.linear(hidden.to(self.linear.weight.dtype)).float()
        return functional.smooth_l1_loss(prediction, target, beta=0.1, reduction="none").mean(dim=1)
