from pathlib import Path

import pytest
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from tokenizers import Tokenizer, models, pre_tokenizers
from transformers import (
    CLIPImageProcessor,
    CLIPVisionConfig,
    LlamaConfig,
    LlavaConfig,
    LlavaForConditionalGeneration,
    LlavaProcessor,
    PreTrainedTokenizerFast,
)

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig


@pytest.fixture(scope="session")
def keysteps(tmp_path_factory: pytest.TempPathFactory) -> LeRobotDataset:
    return fake_keysteps(tmp_path_factory.mktemp("keysteps") / "dataset", episodes=2, image_size=32)


@pytest.fixture
def small_settings() -> dict:
    """Settings of a tiny model from scratch, for images of 32 pixels."""
    widths = {
        "vision_width": 32,
        "vision_layers": 2,
        "vision_heads": 2,
        "text_width": 64,
        "text_layers": 2,
        "text_heads": 2,
    }
    return {
        "cameras": ["left_shoulder", "right_shoulder", "front"],
        "state_names": list(schema.SIM_STATE_NAMES),
        "workspace": [list(bounds) for bounds in schema.WORKSPACE],
        "device": "cpu",
        "push_to_hub": False,
        "image_size": 32,
        "patch_size": 8,
        "dtype": "float32",
        **widths,
    }


@pytest.fixture
def small_config(small_settings: dict) -> LlakeyCommandConfig:
    return LlakeyCommandConfig(**small_settings)


@pytest.fixture
def batch(keysteps: LeRobotDataset) -> dict:
    return next(iter(torch.utils.data.DataLoader(keysteps, batch_size=6)))


@pytest.fixture(scope="session")
def tiny_llava(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A LLaVA-class model with random weights, saved as transformers saves one, that does not know the stop token."""
    words = [
        "task",
        "move",
        "to",
        "the",
        "top",
        "of",
        "grasp",
        "red",
        "green",
        "blue",
        "yellow",
        "block",
        ":",
        ",",
        ".",
    ]
    special = ["<unk>", "<pad>", "<s>", "</s>", "<image>"]
    vocabulary = {text: index for index, text in enumerate([*special, *words])}
    backend = Tokenizer(models.WordLevel(vocabulary, unk_token="<unk>"))
    backend.pre_tokenizer = pre_tokenizers.Whitespace()
    tokenizer = PreTrainedTokenizerFast(
        tokenizer_object=backend, unk_token="<unk>", pad_token="<pad>", bos_token="<s>", eos_token="</s>"
    )
    tokenizer.add_special_tokens({"additional_special_tokens": ["<image>"]})
    image_processor = CLIPImageProcessor(size={"shortest_edge": 16}, crop_size={"height": 16, "width": 16})
    processor = LlavaProcessor(
        image_processor,
        tokenizer,
        patch_size=8,
        vision_feature_select_strategy="default",
        num_additional_image_tokens=1,
    )
    vision = CLIPVisionConfig(
        hidden_size=16, intermediate_size=32, num_hidden_layers=2, num_attention_heads=2, image_size=16, patch_size=8
    )
    text = LlamaConfig(
        vocab_size=len(tokenizer), hidden_size=16, intermediate_size=32, num_hidden_layers=1, num_attention_heads=2
    )
    torch.manual_seed(0)
    model = LlavaForConditionalGeneration(
        LlavaConfig(vision_config=vision, text_config=text, image_token_index=vocabulary["<image>"], image_seq_length=4)
    )
    folder = tmp_path_factory.mktemp("llava")
    model.save_pretrained(folder)
    processor.save_pretrained(folder)
    return folder
