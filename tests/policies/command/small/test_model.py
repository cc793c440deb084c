import pytest
import torch
from torch import nn
from transformers import DynamicCache

from lerobot_llakey import schema
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.small.model import (
    UNIT_METRES,
    CameraProjector,
    ConvolutionalStem,
    KeyframeHead,
    LastLayer,
    build_small,
    init_number_embeddings,
    read_last,
)
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


def test_projector_adds_an_embedding_for_each_camera():
    projector = CameraProjector(8, 16, cameras=3)
    same = torch.rand(1, 5, 8).repeat(6, 1, 1)
    first, second = projector(same).split(3)
    assert torch.allclose(first, second)
    assert not torch.allclose(first[0], first[1])


@pytest.fixture
def model(small_config: LlakeyCommandConfig):
    torch.manual_seed(0)
    return build_small(small_config, WordTokenizer(grammar_words(BASIC_GRAMMAR)))


def _inputs(tokens: int, padded: int) -> dict[str, torch.Tensor]:
    """Two rows of embeddings, the second one padded on the left."""
    mask = torch.ones(2, tokens, dtype=torch.int64)
    mask[1, :padded] = 0
    return {"inputs_embeds": torch.randn(2, tokens, 64), "attention_mask": mask}


@pytest.mark.parametrize("attention", ["eager", "sdpa"])
@pytest.mark.parametrize("padded", [0, 3])
def test_the_last_layer_keeps_the_outputs_at_the_kept_positions(model, attention: str, padded: int) -> None:
    language_model = model.model.language_model
    language_model.set_attn_implementation(attention)
    inputs = _inputs(9, padded)
    whole = language_model(**inputs, use_cache=False).last_hidden_state
    last = language_model(**inputs, use_cache=False, keep=4).last_hidden_state
    assert last.shape == (2, 4, 64)
    torch.testing.assert_close(last, whole[:, -4:], rtol=1e-4, atol=1e-5)


def test_the_last_layer_keeps_the_gradients(model) -> None:
    language_model, inputs = model.model.language_model, _inputs(9, 3)
    gradients = []
    for keep in (None, 4):
        model.zero_grad()
        language_model(**inputs, use_cache=False, keep=keep).last_hidden_state[:, -4:].square().sum().backward()
        gradients.append({name: p.grad.clone() for name, p in language_model.named_parameters() if p.grad is not None})
    assert gradients[0].keys() == gradients[1].keys()
    for name, gradient in gradients[0].items():
        torch.testing.assert_close(gradients[1][name], gradient, rtol=1e-3, atol=1e-4, msg=name)


def test_the_last_layers_cache_holds_all_positions(model) -> None:
    language_model, inputs = model.model.language_model.eval(), _inputs(9, 0)
    after = []
    for keep in (None, 1):
        cache = DynamicCache(config=language_model.config)
        language_model(**inputs, use_cache=True, past_key_values=cache, keep=keep)
        more = {"inputs_embeds": inputs["inputs_embeds"][:, :3], "attention_mask": torch.ones(2, 12, dtype=torch.int64)}
        output = language_model(**more, use_cache=True, past_key_values=cache, keep=keep)
        after.append(output.last_hidden_state[:, -1])
    torch.testing.assert_close(after[1], after[0], rtol=1e-4, atol=1e-5)


def test_only_a_model_with_the_last_layer_skips_positions(model) -> None:
    assert read_last(model, 3) == {"keep": 3}
    layers = model.model.language_model.layers
    assert isinstance(layers[-1], LastLayer)
    layers[-1] = layers[0]
    assert read_last(model, 3) == {}


def test_neighbouring_numbers_start_similar_and_other_words_stay():
    torch.manual_seed(0)
    embedding = nn.Embedding(300, 64)
    before = embedding.weight.detach().clone()
    tokens = list(range(299, 43, -1))  # in the order of the numbers, not of the tokens
    init_number_embeddings(embedding, tokens)
    assert torch.equal(embedding.weight[:44], before[:44])
    curve = embedding.weight.detach()[tokens]
    distances = torch.cdist(curve, curve)
    off_diagonal = distances + torch.eye(len(tokens)) * 9
    assert off_diagonal.min() > 0.1 * distances.mean()
    assert distances.diagonal(1).mean() < 0.6 * distances.mean()


def test_a_correct_keyframe_costs_nothing_and_rows_are_separate():
    head = KeyframeHead(8)
    torch.nn.init.eye_(head.linear.weight)
    torch.nn.init.zeros_(head.linear.bias)
    state, action = torch.rand(2, schema.HAND_DIM), torch.rand(2, schema.ACTION_DIM)
    hidden = torch.cat((state[:, :3] / UNIT_METRES, state[:, 7:8], action[:, :3] / UNIT_METRES, action[:, 7:8]), dim=1)
    assert torch.allclose(head.loss(hidden, state, action), torch.zeros(2))
    hidden[1, 0] += 1.0
    loss = head.loss(hidden, state, action)
    assert loss[0] == 0 and loss[1] > 0


def test_the_keyframe_head_learns():
    torch.manual_seed(0)
    head = KeyframeHead(16)
    hidden, state, action = torch.randn(4, 16), torch.rand(4, schema.HAND_DIM), torch.rand(4, schema.ACTION_DIM)
    optimizer = torch.optim.Adam(head.parameters(), lr=0.1)
    first = head.loss(hidden, state, action).mean()
    for _ in range(100):
        optimizer.zero_grad()
        loss = head.loss(hidden, state, action).mean()
        loss.backward()
        optimizer.step()
    assert loss < 0.1 * first
