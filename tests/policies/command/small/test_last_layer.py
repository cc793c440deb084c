"""The last layer gives the same where it is read, whatever it leaves out."""

import pytest
import torch
from transformers import DynamicCache

from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.small.build import build_small
from lerobot_llakey.policies.command.small.last_layer import LastLayer, read_last
from lerobot_llakey.policies.command.small.tokenizer import WordTokenizer, grammar_words


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
def test_what_is_read_is_the_same(model, attention: str, padded: int) -> None:
    language_model = model.model.language_model
    language_model.set_attn_implementation(attention)
    inputs = _inputs(9, padded)
    whole = language_model(**inputs, use_cache=False).last_hidden_state
    last = language_model(**inputs, use_cache=False, keep=4).last_hidden_state
    assert last.shape == (2, 4, 64)
    torch.testing.assert_close(last, whole[:, -4:], rtol=1e-4, atol=1e-5)


def test_gradients_are_the_same(model) -> None:
    language_model, inputs = model.model.language_model, _inputs(9, 3)
    gradients = []
    for keep in (None, 4):
        model.zero_grad()
        language_model(**inputs, use_cache=False, keep=keep).last_hidden_state[:, -4:].square().sum().backward()
        gradients.append({name: p.grad.clone() for name, p in language_model.named_parameters() if p.grad is not None})
    assert gradients[0].keys() == gradients[1].keys()
    for name, gradient in gradients[0].items():
        torch.testing.assert_close(gradients[1][name], gradient, rtol=1e-3, atol=1e-4, msg=name)


def test_the_cache_holds_all_positions(model) -> None:
    language_model, inputs = model.model.language_model.eval(), _inputs(9, 0)
    after = []
    for keep in (None, 1):
        cache = DynamicCache(config=language_model.config)
        language_model(**inputs, use_cache=True, past_key_values=cache, keep=keep)
        more = {"inputs_embeds": inputs["inputs_embeds"][:, :3], "attention_mask": torch.ones(2, 12, dtype=torch.int64)}
        output = language_model(**more, use_cache=True, past_key_values=cache, keep=keep)
        after.append(output.last_hidden_state[:, -1])
    torch.testing.assert_close(after[1], after[0], rtol=1e-4, atol=1e-5)


def test_only_a_model_with_this_layer_is_told_what_is_read(model) -> None:
    assert read_last(model, 3) == {"keep": 3}
    layers = model.model.language_model.layers
    assert isinstance(layers[-1], LastLayer)
    layers[-1] = layers[0]
    assert read_last(model, 3) == {}
