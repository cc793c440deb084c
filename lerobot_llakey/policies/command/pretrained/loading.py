"""Loads a pretrained image-text model and its processor, rebuilds them from a checkpoint, and freezes parts."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import torch
from torch import nn
from transformers import AutoConfig, AutoModelForImageTextToText, AutoProcessor, BitsAndBytesConfig, PreTrainedModel

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading
from lerobot_llakey.policies.command.model_settings import PARTS
from lerobot_llakey.policies.command.pretrained.encoder import add_stop_token
from lerobot_llakey.saved.folder import require_file

_NOT_CONNECTED = ("couldn't connect", "offline", "locate the file on the hub", "max retries", "connection error")
_PROJECTOR = re.compile(r"(^|\.)(multi_modal_projector|connector|aligner|image_newline|[a-z_]*merger[a-z_]*)(\.|$)")
_VISION = re.compile(r"(^|\.)(vision_tower|vision_model|visual)(\.|$)")


def load_pretrained(
    name: str, weights_dtype: str = "float32", quantize: str | None = None
) -> tuple[PreTrainedModel, Any]:
    """A pretrained image-text model and its processor, with the stop token added if they lack it.

    Args:
        name: Hub name or local folder.
        weights_dtype: "float32" or "bfloat16".
        quantize: "4bit" or None.

    Raises:
        LlakeyError: if the model is unknown, out of reach, takes no images, or cannot be quantised on this machine.
    """
    looks_local = name.startswith((".", "/", "~")) or name.count("/") > 1
    path = Path(name).expanduser()
    if looks_local and not path.is_dir():
        raise LlakeyError(
            f"Expected `model` to be a folder or a Hub name, got {name!r}, which does not exist; check the path."
        )
    source = str(path) if path.is_dir() else name
    options = {"dtype": getattr(torch, weights_dtype), **quantized_loading(quantize)}
    try:
        # By default transformers would ask on the terminal about code beside the weights; it is never run.
        config = AutoConfig.from_pretrained(source, trust_remote_code=False)
        if type(config) not in AutoModelForImageTextToText._model_mapping:
            raise LlakeyError(
                f"Expected `model` to take images and text, got {name!r}, a {config.model_type} model that does not; "
                "name an image-text model."
            )
        processor = AutoProcessor.from_pretrained(source, trust_remote_code=False)
        model = AutoModelForImageTextToText.from_pretrained(source, trust_remote_code=False, **options)
    except (OSError, ValueError, KeyError, ImportError) as error:
        raise LlakeyError(_reason(name, error)) from error
    if not hasattr(processor, "image_processor"):
        raise LlakeyError(
            f"Expected `model` with a processor of images and text, got {name!r} with a {type(processor).__name__}; "
            "save the model's processor beside it."
        )
    vars(model.config).pop("auto_map", None)  # a saved checkpoint must not name the code either
    add_stop_token(model, processor)
    return model, processor


def build_from_assets(folder: Path, weights_dtype: str = "float32") -> tuple[PreTrainedModel, Any]:
    """The architecture of a saved pretrained model, without its weights, and its processor.

    Args:
        folder: written by :func:`save_assets`.
        weights_dtype: "float32" or "bfloat16".

    Raises:
        LlakeyError: if a file is broken or names code to run.
    """
    for file in sorted(folder.rglob("*")):
        if not file.is_dir():
            require_file(file)
        if file.suffix == ".json":
            refuse_code(file)
    with reading(folder, "language model of a checkpoint"):
        processor = AutoProcessor.from_pretrained(folder, trust_remote_code=False, local_files_only=True)
        config = AutoConfig.from_pretrained(folder, trust_remote_code=False, local_files_only=True)
        model = AutoModelForImageTextToText.from_config(
            config, dtype=getattr(torch, weights_dtype), trust_remote_code=False
        )
        add_stop_token(model, processor)
    return model, processor


def refuse_code(file: Path) -> None:
    """Refuse a JSON file of a checkpoint that names code: modules beside it, or kernels on the Hub.

    Raises:
        LlakeyError: naming the file.
    """
    with reading(file, "JSON file"):
        content = json.loads(file.read_text(encoding="utf-8"))
    if isinstance(content, dict) and (named := _code(content)):
        raise LlakeyError(
            f"Expected a language model without code of its own in {file}, got {named}; no code of a checkpoint is run."
        )


def _code(content: Mapping[str, Any]) -> str:
    for name, value in content.items():
        if name == "auto_map" or (name.endswith("attn_implementation") and "/" in str(value)):
            return f"{name} {str(value)[:80]}"
        if (
            isinstance(value, dict) and name != "model" and (found := _code(value))
        ):  # skips a tokenizer's large vocabulary
            return found
    return ""


def save_assets(folder: Path, model: PreTrainedModel, processor: Any) -> None:
    """Save the architecture and its processor, without the weights."""
    folder.mkdir(parents=True, exist_ok=True)
    model.config.save_pretrained(folder)
    processor.save_pretrained(folder)


def _reason(name: str, error: Exception) -> str:
    text = str(error).strip()
    if isinstance(error, LlakeyError):
        return text
    if any(words in text.lower() for words in _NOT_CONNECTED) and not Path(name).expanduser().is_dir():
        return (
            f"Expected the model {name!r} on this disk or the Hub within reach, got neither; download it where there "
            f"is a network (hf download {name}), or name a folder."
        )
    first = text.splitlines()[0] if text else type(error).__name__
    if "trust_remote_code" in text or "custom code" in text:
        return f"Expected a model that needs no code of its own, got {name!r}, which does; use one without."
    if isinstance(error, ImportError):
        return f"Expected the packages that the model {name!r} needs, got a machine without one; install it: {first}"
    return f"Expected `model` to name an image-text model with its processor, got {name!r} ({first}); check the name."


def quantized_loading(quantize: str | None) -> dict[str, Any]:
    """Arguments for ``from_pretrained`` that quantise the weights for QLoRA (Dettmers et al. 2023); {} for None.

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
    """QLoRA's settings: NormalFloat4, quantised scales, products in bfloat16."""
    return BitsAndBytesConfig(
        load_in_4bit=True,
        bnb_4bit_quant_type="nf4",
        bnb_4bit_use_double_quant=True,
        bnb_4bit_compute_dtype=torch.bfloat16,
    )


def part_of(name: str) -> str:
    """The part, out of ``PARTS``, that a parameter or module of an image-text model belongs to.

    Args:
        name: its name in the model. Qwen-VL's projector ("visual.merger") is inside its vision tower.
    """
    if _PROJECTOR.search(name):
        return "projector"
    return "vision" if _VISION.search(name) else "language"


def train_parts(model: nn.Module, trained: Sequence[str]) -> None:
    """Freeze all but some parts of a model.

    Args:
        model: an image-text model of transformers.
        trained: the parts, out of ``PARTS``.

    Raises:
        LlakeyError: if some parts are to be frozen and the model has none of a known name.
    """
    parts = {name: part_of(name) for name, _ in model.named_parameters()}
    missing = sorted(set(PARTS) - set(parts.values()))
    if missing and set(trained) != set(PARTS):
        raise LlakeyError(
            f"Expected {type(model).__name__} to have the parts {list(PARTS)}, got none that is known as "
            f"{' and '.join(missing)}; set train=[vision,projector,language] to train all of it."
        )
    for name, value in model.named_parameters():
        if parts[name] not in trained:
            value.requires_grad_(False)
