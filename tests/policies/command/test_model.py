import pytest
import torch

from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.model import (
    ConvolutionalStem,
    ViewProjector,
    build_small,
    freeze_vision,
    load_pretrained,
)
from lerobot_llakey.policies.command.prompt import STOP
from lerobot_llakey.policies.command.tokenizer import WordTokenizer, grammar_words


def test_shipped_size_is_small():
    model = build_small(LlakeyCommandConfig(device="cpu"), WordTokenizer(grammar_words()))
    assert sum(value.numel() for value in model.parameters()) <= 12e6


@pytest.mark.parametrize("patch_size", [4, 8, 16])
def test_stem_makes_one_token_a_patch(patch_size):
    stem = ConvolutionalStem(48, patch_size)
    assert stem(torch.rand(2, 3, 32, 32)).shape == (2, 48, 32 // patch_size, 32 // patch_size)


def test_stem_refuses_a_patch_it_cannot_halve_to():
    with pytest.raises(ValueError, match="got 12"):
        ConvolutionalStem(48, 12)


def test_projector_tells_the_views_apart():
    projector = ViewProjector(8, 16, views=3)
    same = torch.rand(1, 5, 8).repeat(6, 1, 1)
    first, second = projector(same).split(3)
    assert torch.allclose(first, second)
    assert not torch.allclose(first[0], first[1])


def test_vision_tower_is_frozen_and_the_rest_is_not():
    model = build_small(LlakeyCommandConfig(device="cpu", vision_layers=1, text_layers=1), WordTokenizer(["a"]))
    freeze_vision(model)
    frozen = {name for name, value in model.named_parameters() if not value.requires_grad}
    assert frozen == {name for name, _ in model.named_parameters() if "vision_tower" in name}
    assert frozen


def test_missing_folder_is_named():
    with pytest.raises(ValueError, match="'/no/such/model', which does not exist"):
        load_pretrained("/no/such/model")


def test_folder_without_a_model_is_named(tmp_path):
    with pytest.raises(ValueError, match="Expected `model` to name an image-text model"):
        load_pretrained(str(tmp_path))


def test_stop_token_is_added_with_an_embedding(tiny_llava):
    model, processor = load_pretrained(str(tiny_llava))
    stop = processor.tokenizer.encode(STOP, add_special_tokens=False)
    assert len(stop) == 1
    assert model.get_input_embeddings().num_embeddings > stop[0]
    assert model.generation_config.eos_token_id == stop[0]
    assert processor.tokenizer.convert_tokens_to_ids("<image>") == model.config.image_token_id
