"""Loading a pretrained model's weights in 4 bits, for QLoRA (Dettmers et al. 2023)."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import torch
from transformers import BitsAndBytesConfig

from lerobot_llakey.errors import LlakeyError


def quantized_loading(quantize: str | None) -> dict[str, Any]:
    """What ``from_pretrained`` is told to quantise the weights; nothing where ``quantize`` is None.

    Raises:
        LlakeyError: if bitsandbytes or a CUDA GPU is missing.
    """
    if quantize is None:
        return {}
    missing = [] if find_spec("bitsandbytes") else ["bitsandbytes"]
    missing += [] if torch.cuda.is_available() else ["a CUDA GPU"]
    if missing:
        raise LlakeyError(
            f"Expected bitsandbytes and a CUDA GPU for quantize={quantize}, got a machine without "
            f"{' and '.join(missing)}; use a machine that has them or set quantize=null."
        )
    return {"quantization_config": four_bit_settings(), "device_map": {"": torch.cuda.current_device()}}


def four_bit_settings() -> BitsAndBytesConfig:
    """QLoRA's settings: NormalFloat4, the scales quantised too, products in bfloat16."""
    return BitsAndBytesConfig(
        load_in_4bit=True,
        bnb_4bit_quant_type="nf4",
        bnb_4bit_use_double_quant=True,
        bnb_4bit_compute_dtype=torch.bfloat16,
    )
