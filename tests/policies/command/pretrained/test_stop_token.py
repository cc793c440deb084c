import pytest
import torch
from transformers import AutoModelForImageTextToText, AutoProcessor

from fakes_models import TINY, write_tiny
from lerobot_llakey.policies.command.pretrained.loading import build_from_assets, load_pretrained, save_assets
from lerobot_llakey.policies.command.pretrained.stop_token import add_stop_token
from lerobot_llakey.policies.command.prompt import STOP


@pytest.mark.parametrize("family", TINY)
def test_a_lacking_stop_token_gets_embeddings_that_are_the_mean_of_the_others(family, tmp_path):
    folder = str(write_tiny(family, tmp_path))
    before = AutoModelForImageTextToText.from_pretrained(folder).get_output_embeddings().weight
    model, processor = load_pretrained(folder)
    stop = processor.tokenizer.encode(STOP, add_special_tokens=False)
    assert len(stop) == 1 and stop[0] >= len(AutoProcessor.from_pretrained(folder).tokenizer)
    for layer in (model.get_input_embeddings(), model.get_output_embeddings()):
        assert layer.weight.shape[0] > stop[0]
    assert model.generation_config.eos_token_id == stop[0]
    row = model.get_output_embeddings().weight[stop[0]]
    assert torch.allclose(row, before[: stop[0]].mean(0), atol=1e-6)


def test_added_tokens_and_sizes_are_saved_and_a_second_time_adds_nothing(tmp_path):
    model, processor = load_pretrained(str(write_tiny("llava", tmp_path / "model")))
    save_assets(tmp_path / "assets", model, processor)
    again, saved = build_from_assets(tmp_path / "assets")
    assert saved.tokenizer.get_vocab() == processor.tokenizer.get_vocab()
    assert again.lm_head.weight.shape == model.lm_head.weight.shape
    weights = again.lm_head.weight.clone()
    add_stop_token(again, saved)
    assert torch.equal(again.lm_head.weight, weights)


def test_a_spare_row_of_the_embedding_is_used(tmp_path):
    folder = write_tiny("llava", tmp_path)
    padded = AutoModelForImageTextToText.from_pretrained(folder)
    padded.resize_token_embeddings(padded.get_input_embeddings().num_embeddings + 7)
    padded.save_pretrained(folder)
    model, processor = load_pretrained(str(folder))
    assert model.lm_head.weight.shape == padded.lm_head.weight.shape
    assert processor.tokenizer.convert_tokens_to_ids(STOP) == len(processor.tokenizer) - 1
