import pytest
import torch

from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.small.build import ConvolutionalStem, ViewProjector, build_small
from lerobot_llakey.policies.command.small.tokenizer import WordTokenizer, grammar_words


def test_shipped_size_is_small():
    model = build_small(LlakeyCommandConfig(device="cpu"), WordTokenizer(grammar_words(BASIC_GRAMMAR)))
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
