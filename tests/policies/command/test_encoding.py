import torch

from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.command.encoding import IGNORED
from lerobot_llakey.policies.command.pretrained.encoder import ProcessorEncoder
from lerobot_llakey.policies.command.pretrained.loading import load_pretrained
from lerobot_llakey.policies.command.prompt import Prompt, sentences
from lerobot_llakey.policies.command.small.tokenizer import WordEncoder, WordTokenizer, grammar_words

PROMPTS = [Prompt(("front", "wrist"), "grasp", ""), Prompt(("front", "wrist"), "grasp the robotic arm", "release")]


def _check(encoder, image_id: int, image_tokens: int) -> dict[str, torch.Tensor]:
    images = torch.rand(2, 2, 3, 16, 16)
    alone = encoder.prompts(images, PROMPTS)
    assert ((alone["input_ids"] == image_id).sum(1) == 2 * image_tokens).all()
    inputs, labels = encoder.with_answers(images, PROMPTS, ["grasp", "move to the top of"])
    length = alone["input_ids"].shape[1]
    assert torch.equal(inputs["input_ids"][:, :length], alone["input_ids"])
    assert inputs["attention_mask"].shape == inputs["input_ids"].shape
    kept = labels != IGNORED
    assert torch.equal(inputs["attention_mask"][:, length:].bool(), kept)
    assert torch.equal(inputs["input_ids"][:, length:][kept], labels[kept])
    assert [row[mask][-1] for row, mask in zip(labels, kept, strict=True)] == [encoder.stop_id] * 2
    assert [encoder.decode(row[mask].tolist()) for row, mask in zip(labels, kept, strict=True)] == [
        "grasp",
        "move to the top of",
    ]
    return inputs


def test_word_encoder_pads_on_the_left_and_labels_only_answers():
    tokenizer = WordTokenizer(grammar_words(BASIC_GRAMMAR), sentences(["front", "wrist"]))
    inputs = _check(WordEncoder(tokenizer, 16, 4), tokenizer.image_id, 4)
    assert inputs["attention_mask"][0, 0] == 0 and inputs["attention_mask"][1, 0] == 1
    assert inputs["pixel_values"].shape == (4, 3, 16, 16)
    assert -1 <= inputs["pixel_values"].min() < -0.5


def test_word_encoder_resizes_other_images():
    encoder = WordEncoder(WordTokenizer(grammar_words(BASIC_GRAMMAR)), 8, 1)
    assert encoder.prompts(torch.rand(2, 2, 3, 16, 16), PROMPTS)["pixel_values"].shape == (4, 3, 8, 8)


def test_processor_encoder_does_the_same(tiny_llava):
    model, processor = load_pretrained(str(tiny_llava))
    encoder = ProcessorEncoder(processor, "{system} USER: {request} ASSISTANT:")
    inputs = _check(encoder, model.config.image_token_id, 4)
    assert inputs["pixel_values"].shape == (4, 3, 16, 16)
