import pytest
import torch
from transformers import (
    AutoModelForImageTextToText,
    AutoProcessor,
    CLIPImageProcessor,
    CLIPVisionConfig,
    LlamaConfig,
    LlavaConfig,
    LlavaModel,
    LlavaProcessor,
)

from fakes_models import TINY, llama_tokenizer, write_tiny
from lerobot_llakey.policies.command.encoding import IGNORED
from lerobot_llakey.policies.command.pretrained.encoder import ProcessorEncoder, add_stop_token
from lerobot_llakey.policies.command.pretrained.loading import build_from_assets, load_pretrained, save_assets
from lerobot_llakey.policies.command.prompt import STOP, SYSTEM_MESSAGE, Prompt

PLAIN = Prompt(("front",), "grasp the red block")
VIEWS = ("left_shoulder", "right_shoulder", "front")
IMAGE_TOKENS = 576
"""(336 / 14) ** 2, the class token left out by LLaVA-1.5's "default" selection."""


@pytest.fixture(scope="module")
def llava15() -> LlavaProcessor:
    """LLaVA-1.5's processor by its published settings, with a tokenizer trained here."""
    size = {"size": {"shortest_edge": 336}, "crop_size": {"height": 336, "width": 336}}
    tokenizer = llama_tokenizer(["<image>"])
    tokenizer.add_special_tokens({"additional_special_tokens": [STOP]}, replace_extra_special_tokens=False)
    return LlavaProcessor(
        CLIPImageProcessor(**size),
        tokenizer,
        patch_size=14,
        vision_feature_select_strategy="default",
        num_additional_image_tokens=1,
    )


@pytest.mark.parametrize("views", [VIEWS, VIEWS[-1:]])
def test_llava15_reads_the_papers_prompt_with_576_tokens_an_image(llava15, views):
    encoder = ProcessorEncoder(llava15)
    inputs = encoder.prompts(torch.rand(1, len(views), 3, 128, 128), [Prompt(views, "grasp the red block", None)])
    ids = inputs["input_ids"][0]
    assert (ids == llava15.image_token_id).sum() == IMAGE_TOKENS * len(views)
    assert inputs["pixel_values"].shape == (len(views), 3, 336, 336)
    places = {
        "left_shoulder": "Image from the left shoulder of the robotic arm:",
        "right_shoulder": "Image from the right shoulder of the robotic arm:",
        "front": "Image in front of the robotic arm:",
    }
    shown = "\n".join(f"{places[view]} {'<image>' * IMAGE_TOKENS}" for view in views)
    asked = "Task: grasp the red block, please instruct the robotic arm's next action based on the current images."
    expected = llava15.tokenizer(f"{SYSTEM_MESSAGE} USER: {shown}\n{asked} ASSISTANT:")["input_ids"]
    assert ids.tolist() == expected
    assert ids[0] == llava15.tokenizer.bos_token_id and (ids == ids[0]).sum() == 1


def test_llava15s_vision_tower_gives_as_many_features_as_there_are_image_tokens(llava15):
    size = {"hidden_size": 8, "intermediate_size": 8, "num_attention_heads": 1}
    vision = CLIPVisionConfig(**size, num_hidden_layers=2, image_size=336, patch_size=14)
    text = LlamaConfig(**size, num_hidden_layers=1, vocab_size=len(llava15.tokenizer))
    config = LlavaConfig(vision_config=vision, text_config=text, image_token_index=llava15.image_token_id)
    inputs = ProcessorEncoder(llava15).prompts(torch.rand(1, 3, 3, 128, 128), [Prompt(VIEWS, "grasp", None)])
    model = LlavaModel(config)
    assert [len(features) for features in model.get_image_features(inputs["pixel_values"]).pooler_output] == [576] * 3
    assert model(**inputs).last_hidden_state.shape[1] == inputs["input_ids"].shape[1]


def test_llava15s_labels_are_the_answer_and_the_stop_token_as_they_follow_the_prompt(llava15):
    encoder = ProcessorEncoder(llava15)
    answers = ["grasp the red block", "release"]
    inputs, labels = encoder.with_answers(torch.rand(2, 1, 3, 128, 128), [PLAIN, PLAIN], answers)
    for row, answer in enumerate(answers):
        kept = labels[row][labels[row] != IGNORED].tolist()
        text = encoder.text(PLAIN).replace("<image>", "<image>" * IMAGE_TOKENS)
        whole = llava15.tokenizer(f"{text} {answer}{STOP}")["input_ids"]
        real = inputs["input_ids"][row][inputs["attention_mask"][row].bool()].tolist()
        assert real == whole
        assert whole[-len(kept) :] == kept and kept[-1] == encoder.stop_id
        assert encoder.decode(kept) == answer


@pytest.mark.parametrize("family", TINY)
def test_every_family_keeps_the_order_and_begins_once(family):
    _, processor = TINY[family]()
    processor.tokenizer.add_special_tokens({"additional_special_tokens": [STOP]}, replace_extra_special_tokens=False)
    encoder = ProcessorEncoder(processor)
    prompt = Prompt(("front", "wrist"), "grasp the red block", "release")
    text = encoder.text(prompt)
    image = encoder._image_token
    order = [SYSTEM_MESSAGE, prompt.descriptions[0], image, prompt.descriptions[1], image, "Task: grasp", "release"]
    at = -1
    for piece in order:
        assert (at := text.find(piece, at + 1)) >= 0, piece
    ids = encoder.prompts(torch.rand(1, 2, 3, 32, 32), [prompt])["input_ids"][0]
    if processor.tokenizer.bos_token is not None:
        assert (ids == processor.tokenizer.bos_token_id).sum() == 1
    if family == "llava":
        assert text.endswith(" ASSISTANT:")
    elif family == "paligemma":
        assert not getattr(processor, "chat_template", None) and "USER" not in text
    else:
        assert text == processor.apply_chat_template(prompt.conversation, add_generation_prompt=True)


def test_a_form_of_ones_own_takes_the_place_of_the_chat_template():
    _, processor = TINY["idefics3"]()
    encoder = ProcessorEncoder(processor, "<s>{system} Q: {request} A:")
    assert encoder.text(PLAIN).startswith("<s>You are") and encoder.text(PLAIN).endswith(" A:")


def test_settings_reach_the_processor():
    _, processor = TINY["idefics3"]()
    images = torch.rand(1, 1, 3, 32, 32)
    split = ProcessorEncoder(processor).prompts(images, [PLAIN])["pixel_values"]
    whole = ProcessorEncoder(processor, None, {"do_image_splitting": False}).prompts(images, [PLAIN])["pixel_values"]
    assert (split.shape[1], whole.shape[1]) == (5, 1)


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
