"""Tiny image-text models with random weights, written to disk as ``transformers`` writes the real ones.

Each is of the real model's class, with a real processor, a small tokenizer trained here and a chat template that does
what the real one does, so that the whole way from a model's name to its answers is tested without a download.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from tokenizers import AddedToken, Tokenizer, decoders, models, pre_tokenizers, processors, trainers
from transformers import (
    CLIPImageProcessor,
    CLIPVisionConfig,
    GemmaConfig,
    Idefics3Config,
    Idefics3ForConditionalGeneration,
    Idefics3ImageProcessor,
    Idefics3Processor,
    LlamaConfig,
    LlavaConfig,
    LlavaForConditionalGeneration,
    LlavaNextConfig,
    LlavaNextForConditionalGeneration,
    LlavaNextImageProcessor,
    LlavaNextProcessor,
    LlavaOnevisionConfig,
    LlavaOnevisionForConditionalGeneration,
    LlavaOnevisionImageProcessor,
    LlavaOnevisionProcessor,
    LlavaOnevisionVideoProcessor,
    LlavaProcessor,
    PaliGemmaConfig,
    PaliGemmaForConditionalGeneration,
    PaliGemmaProcessor,
    PreTrainedTokenizerFast,
    Qwen2_5_VLConfig,
    Qwen2_5_VLForConditionalGeneration,
    Qwen2_5_VLProcessor,
    Qwen2Config,
    Qwen2VLConfig,
    Qwen2VLForConditionalGeneration,
    Qwen2VLImageProcessor,
    Qwen2VLProcessor,
    Qwen2VLVideoProcessor,
    SiglipImageProcessor,
    SiglipVisionConfig,
)

from lerobot_llakey.policies.command.prompt import Prompt

_TEXTS = [
    Prompt(("front", "left_shoulder", "right_shoulder", "wrist"), f"{verb} the {colour} block", "").text("")
    for verb in ("move to the top of", "pick up", "grasp", "release")
    for colour in ("red", "green", "blue", "yellow")
]
_TEXT = {"hidden_size": 32, "intermediate_size": 64, "num_hidden_layers": 1, "num_attention_heads": 2}
_VISION = {"hidden_size": 16, "intermediate_size": 32, "num_hidden_layers": 2, "num_attention_heads": 2}

CHATML = (
    "{% for message in messages %}{{ '<|im_start|>' + message['role'] + '\n' }}{% for piece in message['content'] %}"
    "{% if piece['type'] == 'image' %}{{ 'IMAGE' }}{% else %}{{ piece['text'] }}{% endif %}{% endfor %}"
    "{{ '<|im_end|>\n' }}{% endfor %}{% if add_generation_prompt %}{{ '<|im_start|>assistant\n' }}{% endif %}"
)
"""Roles marked as Qwen marks them; IMAGE stands for the model's placeholder."""
ROLES = (
    "<s>{% for message in messages %}{{ message['role'] | capitalize + ': ' }}{% for piece in message['content'] %}"
    "{% if piece['type'] == 'image' %}{{ '<image>' }}{% else %}{{ piece['text'] }}{% endif %}{% endfor %}"
    "{{ '<end_of_utterance>\n' }}{% endfor %}{% if add_generation_prompt %}{{ 'Assistant:' }}{% endif %}"
)
"""Roles in words, with the begin token written out, as SmolVLM and Idefics3 have them."""


def llama_tokenizer(special: list[str], begins: bool = True) -> PreTrainedTokenizerFast:
    """Pieces with a mark for the space before them, as Llama's; begins every text with ``<s>`` where ``begins``."""
    tokenizer = Tokenizer(models.BPE(unk_token="<unk>", byte_fallback=False))
    tokenizer.pre_tokenizer = pre_tokenizers.Metaspace(prepend_scheme="first")
    tokenizer.decoder = decoders.Metaspace(prepend_scheme="first")
    named = {"bos_token": "<s>", "eos_token": "</s>", "unk_token": "<unk>", "pad_token": "<pad>"}
    if begins:
        tokenizer.post_processor = processors.TemplateProcessing("<s> $A", special_tokens=[("<s>", 0)])
    return _trained(tokenizer, special, **named)


def byte_tokenizer(special: list[str], **named: str) -> PreTrainedTokenizerFast:
    """Pieces of bytes, as those of GPT-2 and Qwen."""
    tokenizer = Tokenizer(models.BPE())
    tokenizer.pre_tokenizer = pre_tokenizers.ByteLevel(add_prefix_space=False)
    tokenizer.decoder = decoders.ByteLevel()
    return _trained(tokenizer, special, **named)


def _trained(tokenizer: Tokenizer, special: list[str], **named: str) -> PreTrainedTokenizerFast:
    alphabet = pre_tokenizers.ByteLevel.alphabet() if isinstance(tokenizer.decoder, decoders.ByteLevel) else []
    first = [AddedToken(text, normalized=False, special=True) for text in dict.fromkeys([*named.values(), *special])]
    trainer = trainers.BpeTrainer(
        vocab_size=600, special_tokens=first, initial_alphabet=alphabet, show_progress=False, min_frequency=1
    )
    tokenizer.train_from_iterator(_TEXTS, trainer)
    return PreTrainedTokenizerFast(tokenizer_object=tokenizer, additional_special_tokens=special, **named)


def _llava() -> tuple[Any, Any]:
    tokenizer = llama_tokenizer(["<image>"])
    size = {"size": {"shortest_edge": 16}, "crop_size": {"height": 16, "width": 16}}
    processor = LlavaProcessor(
        CLIPImageProcessor(**size),
        tokenizer,
        patch_size=8,
        vision_feature_select_strategy="default",
        num_additional_image_tokens=1,
    )
    config = LlavaConfig(
        vision_config=CLIPVisionConfig(**_VISION, image_size=16, patch_size=8),
        text_config=LlamaConfig(**_TEXT, vocab_size=len(tokenizer)),
        image_token_index=tokenizer.convert_tokens_to_ids("<image>"),
        image_seq_length=4,
    )
    return LlavaForConditionalGeneration(config), processor


def _llava_next() -> tuple[Any, Any]:
    tokenizer = llama_tokenizer(["<image>", "<end_of_utterance>"])
    tiles = [[16, 32], [32, 16]]
    size = {"size": {"shortest_edge": 16}, "crop_size": {"height": 16, "width": 16}, "image_grid_pinpoints": tiles}
    processor = LlavaNextProcessor(
        LlavaNextImageProcessor(**size),
        tokenizer,
        patch_size=8,
        vision_feature_select_strategy="default",
        num_additional_image_tokens=1,
        chat_template=ROLES,
    )
    config = LlavaNextConfig(
        vision_config=CLIPVisionConfig(**_VISION, image_size=16, patch_size=8),
        text_config=LlamaConfig(**_TEXT, vocab_size=len(tokenizer)),
        image_token_index=tokenizer.convert_tokens_to_ids("<image>"),
        image_grid_pinpoints=tiles,
        image_seq_length=4,
    )
    return LlavaNextForConditionalGeneration(config), processor


def _llava_onevision() -> tuple[Any, Any]:
    special = ["<|im_start|>", "<image>", "<video>"]
    tokenizer = byte_tokenizer(special, eos_token="<|im_end|>", pad_token="<|endoftext|>")
    tiles = [[16, 16], [16, 32]]
    size = {"height": 16, "width": 16}
    processor = LlavaOnevisionProcessor(
        LlavaOnevisionImageProcessor(size=size, image_grid_pinpoints=tiles),
        tokenizer,
        LlavaOnevisionVideoProcessor(size=size),
        num_image_tokens=4,
        vision_feature_select_strategy="full",
        chat_template=CHATML.replace("IMAGE", "<image>"),
    )
    config = LlavaOnevisionConfig(
        vision_config=SiglipVisionConfig(**_VISION, image_size=16, patch_size=8, vision_use_head=False),
        text_config=Qwen2Config(**_TEXT, num_key_value_heads=2, vocab_size=len(tokenizer)),
        image_token_index=tokenizer.convert_tokens_to_ids("<image>"),
        video_token_index=tokenizer.convert_tokens_to_ids("<video>"),
        image_grid_pinpoints=tiles,
    )
    return LlavaOnevisionForConditionalGeneration(config), processor


def _idefics3() -> tuple[Any, Any]:
    special = ["<image>", "<fake_token_around_image>", "<global-img>", "<end_of_utterance>"]
    special += [f"<row_{row}_col_{column}>" for row in (1, 2) for column in (1, 2)]
    tokenizer = byte_tokenizer(special, bos_token="<s>", eos_token="</s>", pad_token="<pad>")
    size = {"size": {"longest_edge": 32}, "max_image_size": {"longest_edge": 16}}
    processor = Idefics3Processor(Idefics3ImageProcessor(**size), tokenizer, image_seq_len=1, chat_template=ROLES)
    config = Idefics3Config(
        vision_config={**_VISION, "image_size": 16, "patch_size": 8},
        text_config=LlamaConfig(**_TEXT, vocab_size=len(tokenizer), pad_token_id=tokenizer.pad_token_id),
        image_token_id=tokenizer.convert_tokens_to_ids("<image>"),
        scale_factor=2,
        tie_word_embeddings=True,
    )
    return Idefics3ForConditionalGeneration(config), processor


def _qwen_processor(kind: type) -> Any:
    special = ["<|im_start|>", "<|vision_start|>", "<|vision_end|>", "<|image_pad|>", "<|video_pad|>"]
    tokenizer = byte_tokenizer(special, eos_token="<|im_end|>", pad_token="<|endoftext|>")
    size = {"patch_size": 4, "merge_size": 2, "size": {"shortest_edge": 64, "longest_edge": 1024}}
    template = CHATML.replace("IMAGE", "<|vision_start|><|image_pad|><|vision_end|>")
    return kind(Qwen2VLImageProcessor(**size), tokenizer, Qwen2VLVideoProcessor(**size), chat_template=template)


def _qwen_config(kind: type, processor: Any, vision: dict[str, Any]) -> Any:
    ids = {
        f"{name}_token_id": processor.tokenizer.convert_tokens_to_ids(f"<|{token}|>")
        for name, token in (("image", "image_pad"), ("video", "video_pad"), ("vision_start", "vision_start"))
    }
    rope = {"rope_type": "default", "mrope_section": [2, 3, 3], "rope_theta": 10000.0}
    text = {**_TEXT, "num_key_value_heads": 2, "vocab_size": len(processor.tokenizer), "rope_parameters": rope}
    return kind(text_config=text, vision_config={"patch_size": 4, "spatial_merge_size": 2, **vision}, **ids)


def _qwen2_vl() -> tuple[Any, Any]:
    processor = _qwen_processor(Qwen2VLProcessor)
    vision = {"depth": 2, "embed_dim": 16, "hidden_size": 32, "num_heads": 2, "mlp_ratio": 2}
    return Qwen2VLForConditionalGeneration(_qwen_config(Qwen2VLConfig, processor, vision)), processor


def _qwen2_5_vl() -> tuple[Any, Any]:
    processor = _qwen_processor(Qwen2_5_VLProcessor)
    vision = {"depth": 2, "hidden_size": 16, "intermediate_size": 32, "num_heads": 2, "out_hidden_size": 32}
    vision |= {"window_size": 16, "fullatt_block_indexes": [1]}
    return Qwen2_5_VLForConditionalGeneration(_qwen_config(Qwen2_5_VLConfig, processor, vision)), processor


def _paligemma() -> tuple[Any, Any]:
    tokenizer = llama_tokenizer([], begins=False)
    images = SiglipImageProcessor(size={"height": 16, "width": 16})
    images.image_seq_length = 4
    processor = PaliGemmaProcessor(images, tokenizer)
    config = PaliGemmaConfig(
        vision_config=SiglipVisionConfig(**_VISION, image_size=16, patch_size=8, vision_use_head=False).to_dict(),
        text_config=GemmaConfig(
            **_TEXT, num_key_value_heads=1, head_dim=16, vocab_size=len(tokenizer), pad_token_id=tokenizer.pad_token_id
        ).to_dict(),
        image_token_index=processor.image_token_id,
        projection_dim=32,
        vocab_size=len(tokenizer),
    )
    return PaliGemmaForConditionalGeneration(config), processor


TINY: dict[str, Callable[[], tuple[Any, Any]]] = {
    "llava": _llava,
    "llava_next": _llava_next,
    "llava_onevision": _llava_onevision,
    "idefics3": _idefics3,
    "qwen2_vl": _qwen2_vl,
    "qwen2_5_vl": _qwen2_5_vl,
    "paligemma": _paligemma,
}
"""Every family, by ``transformers``' name."""


def write_tiny(family: str, folder: str | Path) -> Path:
    """Write a tiny model and its processor into a folder; the same weights every time.

    Args:
        family: one of ``TINY``.
        folder: where to.
    """
    torch.manual_seed(0)
    model, processor = TINY[family]()
    model.save_pretrained(folder)
    processor.save_pretrained(folder)
    return Path(folder)
