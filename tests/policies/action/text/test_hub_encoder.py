"""A frozen text model of the Hub: a tiny CLIP on disk, with its tokenizer."""

import json
import shutil
from pathlib import Path

import pytest
import torch
from lerobot.configs import PreTrainedConfig
from safetensors import safe_open
from transformers import CLIPTextConfig, CLIPTextModel, CLIPTokenizer

from fakes_action import observation, small_config
from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.policies.action.text import hub_encoder
from lerobot_llakey.policies.action.text.hub_encoder import HubTextEncoder

WIDTH = 16


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("clip")
    letters = [chr(code) for code in range(ord("a"), ord("z") + 1)]
    tokens = [*letters, *(letter + "</w>" for letter in letters), "<|startoftext|>", "<|endoftext|>"]
    (folder / "vocab.json").write_text(json.dumps({token: index for index, token in enumerate(tokens)}))
    (folder / "merges.txt").write_text("#version: 0.2\n")
    tokenizer = CLIPTokenizer.from_pretrained(folder, model_max_length=40)
    tokenizer.save_pretrained(folder)
    torch.manual_seed(0)
    config = CLIPTextConfig(
        vocab_size=len(tokens),
        hidden_size=WIDTH,
        intermediate_size=32,
        num_hidden_layers=2,
        num_attention_heads=2,
        max_position_embeddings=40,
        bos_token_id=len(tokens) - 2,
        eos_token_id=len(tokens) - 1,
    )
    CLIPTextModel(config).save_pretrained(folder)
    return folder


def counting(encoder: HubTextEncoder) -> list[int]:
    calls: list[int] = []
    encoder._frozen[0].register_forward_hook(lambda *_: calls.append(1))
    return calls


def test_token_features_are_the_models_own(clip: Path) -> None:
    encoder = HubTextEncoder(str(clip))
    words, padding = encoder(["grasp the lid", "go"])
    # Each letter is a token here, between the two that mark start and end.
    assert encoder.width == WIDTH and words.shape == (2, 13, WIDTH)
    assert (~padding).sum(dim=1).tolist() == [13, 4]
    model, tokenizer = CLIPTextModel.from_pretrained(clip).eval(), CLIPTokenizer.from_pretrained(clip)
    with torch.no_grad():
        expected = model(**tokenizer("go", return_tensors="pt")).last_hidden_state[0]
    assert torch.allclose(words[1, :4], expected, atol=1e-5)  # padded and alone are summed in other orders


def test_each_text_is_encoded_once_even_between_deciding_and_training(clip: Path) -> None:
    encoder = HubTextEncoder(str(clip))
    calls = counting(encoder)
    with torch.inference_mode():
        encoder(["grasp the lid", "go", "go"])
    encoder.train()
    words, _ = encoder(["go", "grasp the lid"])
    assert len(calls) == 2
    weight = torch.ones(WIDTH, requires_grad=True)
    (words * weight).sum().backward()  # features made in inference mode could not be trained with
    assert weight.grad is not None and not words.requires_grad


def test_the_texts_kept_are_bounded(clip: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hub_encoder, "_KEPT_TEXTS", 2)
    encoder = HubTextEncoder(str(clip))
    calls = counting(encoder)
    encoder(["a", "b", "a", "c"])  # "b" has waited longest
    encoder(["a", "c"])
    assert len(calls) == 3
    encoder(["b"])
    assert len(calls) == 4


def test_a_text_that_would_be_cut_is_refused(clip: Path) -> None:
    with pytest.raises(ValueError, match=r"at most 40 tokens for policy\.text_model, got more \('grasp grasp"):
        HubTextEncoder(str(clip))(["grasp " * 30])


def test_the_model_is_neither_trained_nor_saved_and_comes_back_by_its_name(clip: Path, tmp_path: Path) -> None:
    torch.manual_seed(0)
    policy = LlakeyActionPolicy(small_config(text_model=str(clip), condition_on="both"))
    assert not list(policy.text.parameters()) and not policy.text.state_dict()
    before = {name: value.clone() for name, value in policy.text._frozen[0].state_dict().items()}
    batch, _, _ = observation(rows=2)
    optimiser = torch.optim.SGD(policy.get_optim_params(), lr=0.1)
    policy.train()
    loss, _ = policy.forward(batch)
    loss.backward()
    optimiser.step()
    assert not policy.text._frozen[0].training
    assert all(torch.equal(value, before[name]) for name, value in policy.text._frozen[0].state_dict().items())
    action = policy.select_action(batch)
    policy.save_pretrained(tmp_path)
    with safe_open(tmp_path / "model.safetensors", framework="pt") as file:
        assert not [key for key in file.keys() if key.startswith("text.")]  # noqa: SIM118
    assert json.loads((tmp_path / "config.json").read_text())["text_model"] == str(clip)
    with pytest.raises(
        ValueError, match=rf"names the place '{clip}'; if it is yours, give --policy\.text_model={clip}"
    ):
        LlakeyActionPolicy.from_pretrained(tmp_path)
    config = PreTrainedConfig.from_pretrained(tmp_path, cli_overrides=[f"--text_model={clip}"])
    loaded = LlakeyActionPolicy.from_pretrained(tmp_path, config=config)
    assert torch.equal(loaded.select_action(batch), action)


def test_a_published_design_listens_to_it(clip: Path) -> None:
    torch.manual_seed(0)
    settings = {"design": "rvt2", "view_size": 44, "patch_size": 11, "token_width": 32, "transformer_layers": 2}
    policy = LlakeyActionPolicy(small_config(text_model=str(clip), **settings)).eval()
    batch, _, _ = observation(rows=1)
    losses = [policy.forward(batch | {schema.INSTRUCTION: [text]})[0].item() for text in ("grasp it", "release it")]
    assert abs(losses[0] - losses[1]) > 1e-5


def test_an_unknown_name_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"policy\.text_model to name a text model .*, or set it to null"):
        HubTextEncoder(str(tmp_path / "nothing"))


def test_a_name_that_the_hub_does_not_give_is_said_as_what_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_OFFLINE", True)
    monkeypatch.setattr("transformers.utils.hub.is_offline_mode", lambda: True)
    with pytest.raises(LlakeyError, match=r"on this disk or the Hub within reach, got neither for 'nobody/no-model'"):
        HubTextEncoder("nobody/no-model")


def test_code_beside_the_weights_is_refused_without_a_question(
    clip: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "clip"
    shutil.copytree(clip, folder)
    ran = tmp_path / "ran"
    (folder / "config.json").write_text(
        json.dumps({"model_type": "nobody-knows", "auto_map": {"AutoConfig": "code.Own", "AutoModel": "code.Own"}})
    )
    (folder / "code.py").write_text(f"open({str(ran)!r}, 'w')\nclass Own: pass\n")
    monkeypatch.setattr("builtins.input", lambda *_: pytest.fail("asked on the terminal"))
    with pytest.raises(LlakeyError, match=r"policy\.text_model"):
        HubTextEncoder(str(folder))
    assert not ran.exists()
