"""What the processor is, what it can, and how busy it is: without it a speed says little."""

from __future__ import annotations

import os
import platform
from pathlib import Path
from typing import Any

import torch

from lerobot_llakey.policies.precision import has_bfloat16

_INFO = Path("/proc/cpuinfo")
_UNITS = ("avx2", "avx512_f", "avx512_vnni", "avx512_bf16", "amx_bf16")
"""Of PyTorch's list of what a processor has; the last two compute in bfloat16."""
_LIMITS = ("ONEDNN_MAX_CPU_ISA", "ATEN_CPU_CAPABILITY")
"""Environment variables that keep PyTorch from what the processor has."""


def processor_name(info: str | None = None) -> str:
    """The model's name, with its family and model number where there are any: clouds tell short names.

    Args:
        info: as in /proc/cpuinfo, which is read by default; where it tells nothing, what Python's ``platform`` says.
    """
    if info is None:
        info = _INFO.read_text() if _INFO.exists() else ""
    told: dict[str, str] = {}
    for line in info.splitlines():
        key, _, value = line.partition(":")
        told.setdefault(key.strip(), value.strip())
    name = told.get("model name")
    if not name:
        return platform.processor() or platform.machine()
    numbers = [f"{key.removeprefix('cpu ')} {told[key]}" for key in ("cpu family", "model") if key in told]
    return f"{name} ({', '.join(numbers)})" if numbers else name


def machine() -> dict[str, Any]:
    """What figures are measured on."""
    units = torch.cpu.get_capabilities()
    limits = [f"{name}={os.environ[name]}" for name in _LIMITS if name in os.environ]
    return {
        "processor": processor_name(),
        "cores": os.cpu_count(),
        "instruction_sets": " ".join(name for name in _UNITS if units.get(name)) or platform.machine(),
        "used_by_pytorch": " ".join([torch.backends.cpu.get_cpu_capability(), *limits]),
        "computes_bfloat16": has_bfloat16("cpu"),
        "gpu": torch.cuda.get_device_name() if torch.cuda.is_available() else None,
        "torch": torch.__version__,
    }


def load() -> float | None:
    """Processes that ran or waited for a core in the last minute, on average; None where the system does not tell."""
    return round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None
