import pytest
import torch

from lerobot_llakey.diagnostics import processor

EPYC = "processor\t: 0\ncpu family\t: 25\nmodel\t\t: 1\nmodel name\t: AMD EPYC\n\nprocessor\t: 1\n"


def test_a_processor_is_named_as_the_kernel_names_it() -> None:
    assert processor.processor_name(EPYC) == "AMD EPYC (family 25, model 1)"
    assert processor.processor_name("model name : Apple") == "Apple"
    assert processor.processor_name("") != ""


def test_what_it_has_and_what_is_left_of_it_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cpu, "get_capabilities", lambda: {"avx2": True, "avx512_bf16": True, "fma3": True})
    monkeypatch.setenv("ONEDNN_MAX_CPU_ISA", "AVX2")
    told = processor.machine()
    assert told["instruction_sets"] == "avx2 avx512_bf16"
    assert "ONEDNN_MAX_CPU_ISA=AVX2" in told["used_by_pytorch"]
    assert told["computes_bfloat16"] is False
