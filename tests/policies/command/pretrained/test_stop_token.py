from lerobot_llakey.policies.command.pretrained.loading import load_pretrained
from lerobot_llakey.policies.command.prompt import STOP


def test_stop_token_is_added_with_an_embedding(tiny_llava):
    model, processor = load_pretrained(str(tiny_llava))
    stop = processor.tokenizer.encode(STOP, add_special_tokens=False)
    assert len(stop) == 1
    assert model.get_input_embeddings().num_embeddings > stop[0]
    assert model.generation_config.eos_token_id == stop[0]
    assert processor.tokenizer.convert_tokens_to_ids("<image>") == model.config.image_token_id
