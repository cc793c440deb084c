import json
import os

import pytest
import torch
from torch import nn
from transformers import LlamaConfig, LlamaForCausalLM

from fakes_models import TINY, llama_tokenizer, write_tiny
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.command.pretrained import loading
from lerobot_llakey.policies.command.pretrained.loading import (
    build_from_assets,
    load_pretrained,
    part_of,
    save_assets,
    train_parts,
)


def test_weights_come_in_the_precision_asked_for(tmp_path):
    folder = str(write_tiny("llava", tmp_path))
    for dtype in ("float32", "bfloat16"):
        model, _ = load_pretrained(folder, dtype)
        assert {value.dtype for value in model.parameters()} == {getattr(torch, dtype)}


def test_missing_folder_is_named():
    with pytest.raises(ValueError, match="'/no/such/model', which does not exist"):
        load_pretrained("/no/such/model")


def test_folder_without_a_model_is_named(tmp_path):
    with pytest.raises(ValueError, match="Expected `model` to name an image-text model"):
        load_pretrained(str(tmp_path))


def test_no_network_and_not_on_this_disk(monkeypatch, tmp_path):
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_OFFLINE", True)
    monkeypatch.setattr("transformers.utils.hub.is_offline_mode", lambda: True)
    with pytest.raises(
        ValueError, match=r"'nobody/no-model' on this disk or the Hub within reach, got neither"
    ) as caught:
        load_pretrained("nobody/no-model")
    assert "\n" not in str(caught.value)


def test_a_model_without_images_is_named(tmp_path):
    config = LlamaConfig(vocab_size=700, hidden_size=8, intermediate_size=8, num_hidden_layers=1, num_attention_heads=1)
    LlamaForCausalLM(config).save_pretrained(tmp_path)
    llama_tokenizer([]).save_pretrained(tmp_path)
    with pytest.raises(ValueError, match=r"Expected `model` to take images and text, got .*, a llama model"):
        load_pretrained(str(tmp_path))


def test_a_model_whose_processor_is_missing_is_named(tmp_path):
    folder = write_tiny("llava", tmp_path)
    for path in folder.glob("*processor*"):
        path.unlink()
    with pytest.raises(ValueError, match=r"Expected `model` "):
        load_pretrained(str(folder))


def test_a_missing_package_is_named(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise ImportError("Package `num2words` is required to run SmolVLM processor.\nMore lines.")

    monkeypatch.setattr("transformers.AutoProcessor.from_pretrained", refuse)
    with pytest.raises(ValueError, match="got a machine without one; install it: Package `num2words` is required"):
        load_pretrained(str(write_tiny("llava", tmp_path)))


@pytest.fixture
def assets(tmp_path):
    save_assets(tmp_path / "assets", *load_pretrained(str(write_tiny("llava", tmp_path / "llava"))))
    return tmp_path / "assets"


def _told(file, **changes):
    file.write_text(json.dumps(json.loads(file.read_text()) | changes))


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("config.json", {"auto_map": {"AutoConfig": "code.Own"}}),
        ("config.json", {"text_config": {"model_type": "llama", "auto_map": {"AutoConfig": "code.Own"}}}),
        ("config.json", {"attn_implementation": "somebody/kernels"}),
        ("tokenizer_config.json", {"auto_map": {"AutoTokenizer": ["code.Own", None]}}),
    ],
)
def test_a_checkpoints_language_model_runs_no_code_and_asks_nothing(assets, monkeypatch, name, changes):
    monkeypatch.setattr("builtins.input", lambda *_: pytest.fail("asked on the terminal"))
    (assets / "code.py").write_text("raise SystemExit('ran')")
    build_from_assets(assets)
    _told(assets / name, **changes)
    with pytest.raises(LlakeyError, match=rf"without code of its own in .*{name}"):
        build_from_assets(assets)


def test_a_pretrained_model_that_needs_code_is_refused_without_a_question(tmp_path, monkeypatch):
    monkeypatch.setattr("builtins.input", lambda *_: pytest.fail("asked on the terminal"))
    folder = write_tiny("llava", tmp_path)
    _told(folder / "config.json", model_type="nobody-knows", auto_map={"AutoConfig": "code.Own"})
    (folder / "code.py").write_text("raise SystemExit('ran')")
    with pytest.raises(LlakeyError, match="Expected a model that needs no code of its own"):
        load_pretrained(str(folder))


@pytest.mark.parametrize("name", ["config.json", "tokenizer.json", "processor_config.json"])
def test_a_broken_file_of_a_checkpoints_language_model_is_one_sentence(assets, name):
    file = assets / name
    file.write_bytes(file.read_bytes()[:-20])
    with pytest.raises(LlakeyError, match=r"assets"):
        build_from_assets(assets)
    file.unlink()
    os.mkfifo(file)
    with pytest.raises(LlakeyError, match=rf"{name}, got a named pipe"):
        build_from_assets(assets)


def test_nothing_is_quantised_unless_asked():
    assert loading.quantized_loading(None) == {}


def test_four_bits_are_those_of_qlora():
    settings = loading.four_bit_settings()
    assert settings.load_in_4bit and settings.bnb_4bit_use_double_quant
    assert (settings.bnb_4bit_quant_type, settings.bnb_4bit_compute_dtype) == ("nf4", torch.bfloat16)


def test_a_machine_without_what_it_needs_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    monkeypatch.setattr(loading, "find_spec", lambda name: None)
    config = LlakeyCommandConfig(
        device="cpu", model=str(write_tiny("llava", tmp_path)), quantize="4bit", cameras=["front"]
    )
    with pytest.raises(ValueError, match="quantize=4bit, got a machine without bitsandbytes and a CUDA GPU"):
        LlakeyCommandPolicy(config)


def test_weights_of_four_bits_are_not_trained_without_adapters(tmp_path):
    model = str(write_tiny("llava", tmp_path))
    policy = LlakeyCommandPolicy(LlakeyCommandConfig(device="cpu", model=model, cameras=["front"]))
    policy.config.quantize = "4bit"
    with pytest.raises(ValueError, match=r"Expected adapters to train with quantize=4bit.*--peft"):
        policy.get_optim_params()
    policy.config.use_peft = True
    assert policy.get_optim_params()


def _trained(model) -> set[str]:
    return {part_of(name) for name, value in model.named_parameters() if value.requires_grad}


@pytest.mark.parametrize("family", TINY)
@pytest.mark.parametrize("parts", [{"projector", "language"}, {"vision", "projector"}, {"language"}])
def test_the_parts_of_every_family_are_told_apart(family, parts):
    model, _ = TINY[family]()
    train_parts(model, sorted(parts))
    assert _trained(model) == parts
    towers = ("vision_tower", "vision_model", "visual.blocks")
    for name, value in model.named_parameters():
        if any(tower in name for tower in towers):
            assert value.requires_grad == ("vision" in parts), name


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("model.visual.merger.mlp.0.weight", "projector"),
        ("model.visual.deepstack_merger_list.0.norm.weight", "projector"),
        ("model.visual.blocks.0.norm1.weight", "vision"),
        ("model.image_newline", "projector"),
        ("model.language_model.layers.0.mlp.up_proj.weight", "language"),
        ("lm_head.weight", "language"),
    ],
)
def test_names_tell_the_part(name, part):
    assert part_of(name) == part


def test_a_model_of_unknown_parts_is_named_unless_all_of_it_is_trained():
    model = nn.Sequential(nn.Linear(2, 2))
    train_parts(model, ["vision", "projector", "language"])
    with pytest.raises(ValueError, match=r"got none that is known as projector and vision; set train="):
        train_parts(model, ["language"])
