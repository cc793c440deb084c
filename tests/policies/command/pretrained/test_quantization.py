import pytest
import torch

from fakes_models import write_tiny
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.command.pretrained import quantization


def test_nothing_is_quantised_unless_asked():
    assert quantization.quantized_loading(None) == {}


def test_four_bits_are_those_of_qlora():
    settings = quantization.four_bit_settings()
    assert settings.load_in_4bit and settings.bnb_4bit_use_double_quant
    assert (settings.bnb_4bit_quant_type, settings.bnb_4bit_compute_dtype) == ("nf4", torch.bfloat16)


def test_a_machine_without_what_it_needs_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    monkeypatch.setattr(quantization, "find_spec", lambda name: None)
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
