"""The precision follows the device."""

import logging

import pytest
import torch

from lerobot_llakey.policies import precision


@pytest.fixture(autouse=True)
def forgotten() -> None:
    precision._fastest.cache_clear()


@pytest.mark.parametrize(
    ("units", "limit", "expected"),
    [
        ({"avx2": True}, None, torch.float32),
        ({"avx2": True, "avx512_bf16": True}, None, torch.bfloat16),
        ({"avx2": True, "amx_bf16": True}, "AVX512_CORE_AMX", torch.bfloat16),
        ({"avx2": True, "avx512_bf16": True}, "avx2", torch.float32),
    ],
)
def test_a_processor_computes_in_what_it_has_units_for(
    monkeypatch: pytest.MonkeyPatch, units: dict[str, bool], limit: str | None, expected: torch.dtype
) -> None:
    monkeypatch.setattr(torch.cpu, "get_capabilities", lambda: units)
    monkeypatch.delenv("ONEDNN_MAX_CPU_ISA", raising=False)
    if limit is not None:
        monkeypatch.setenv("ONEDNN_MAX_CPU_ISA", limit)
    assert precision.resolve("auto", "cpu") is expected
    with precision.autocast("auto", "cpu"):
        assert torch.is_autocast_enabled("cpu") == (expected is torch.bfloat16)


@pytest.mark.parametrize("supported", [True, False])
def test_a_gpu_says_itself_whether_it_imitates(monkeypatch: pytest.MonkeyPatch, supported: bool) -> None:
    def answer(including_emulation: bool = True) -> bool:
        return supported or including_emulation

    monkeypatch.setattr(torch.cuda, "is_bf16_supported", answer)
    assert precision.has_bfloat16("cuda:1") == supported


def test_what_is_set_is_taken() -> None:
    assert precision.resolve("bfloat16", "cpu") is torch.bfloat16
    assert precision.resolve("float32", "cuda") is torch.float32
    with precision.autocast("bfloat16", "cpu"):
        assert torch.get_autocast_dtype("cpu") is torch.bfloat16


def test_the_choice_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        for _ in range(3):
            precision.resolve("auto", "cpu")
    assert len(caplog.messages) == 1 and "dtype=auto" in caplog.messages[0]
