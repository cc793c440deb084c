"""In which precision a device computes fastest: bfloat16 where it has the units for it, float32 elsewhere.

A processor without such units imitates bfloat16: a matrix product then takes some seventy times as long as in float32.
"""

from __future__ import annotations

import logging
import os
from functools import cache

import torch

PRECISIONS = ("auto", "bfloat16", "float32")
"""What ``dtype`` may be; "auto" is bfloat16 where :func:`has_bfloat16` and float32 elsewhere."""
_LIMITED = ("SSE41", "AVX", "AVX2", "AVX2_VNNI", "AVX2_VNNI_2", "AVX512_CORE", "AVX512_CORE_VNNI")
"""Values of ONEDNN_MAX_CPU_ISA that keep oneDNN from a processor's bfloat16 units."""


def has_bfloat16(device: torch.device | str) -> bool:
    """Whether a device computes in bfloat16 itself rather than by imitation.

    Args:
        device: GPUs say so themselves; of processors, those with avx512_bf16 or AMX that oneDNN may use.
    """
    kind = torch.device(device).type
    if kind == "cuda":
        return torch.cuda.is_bf16_supported(including_emulation=False)
    if kind == "xpu":
        return True
    if kind != "cpu" or os.environ.get("ONEDNN_MAX_CPU_ISA", "").upper() in _LIMITED:
        return False
    units = torch.cpu.get_capabilities()
    return bool(units.get("avx512_bf16") or units.get("amx_bf16"))


def resolve(dtype: str, device: torch.device | str) -> torch.dtype:
    """The precision that a setting means on a device, logged when it was chosen here.

    Args:
        dtype: one of PRECISIONS.
        device: to compute on.
    """
    if dtype != "auto":
        return getattr(torch, dtype)
    return _fastest(torch.device(device).type)


def autocast(dtype: str, device: torch.device | str) -> torch.autocast:
    """PyTorch's automatic mixed precision as a setting asks for it; weights stay as they are.

    Args:
        dtype: one of PRECISIONS.
        device: to compute on.
    """
    enabled = resolve(dtype, device) is torch.bfloat16
    return torch.autocast(torch.device(device).type, dtype=torch.bfloat16, enabled=enabled)


@cache
def _fastest(kind: str) -> torch.dtype:
    """Kept for each kind of device, so that the choice is made and logged once a process."""
    chosen = torch.bfloat16 if has_bfloat16(kind) else torch.float32
    logging.getLogger(__name__).info("Computing in %s on %s (dtype=auto).", str(chosen).removeprefix("torch."), kind)
    return chosen
