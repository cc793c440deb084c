"""Loads a pretrained image-text model with its processor, and rebuilds one from a checkpoint."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from transformers import AutoConfig, AutoModelForImageTextToText, AutoProcessor, PreTrainedModel

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading
from lerobot_llakey.policies.command.pretrained.quantization import quantized_loading
from lerobot_llakey.policies.command.pretrained.settings import ASSETS as ASSETS
from lerobot_llakey.policies.command.pretrained.stop_token import add_stop_token
from lerobot_llakey.saved.folder import require_file

_NOT_CONNECTED = ("couldn't connect", "offline", "locate the file on the hub", "max retries", "connection error")


def load_pretrained(
    name: str, weights_dtype: str = "float32", quantize: str | None = None
) -> tuple[PreTrainedModel, Any]:
    """A pretrained image-text model and its processor, taught the stop token where it is lacking.

    Args:
        name: Hub name or local folder.
        weights_dtype: "float32" or "bfloat16".
        quantize: "4bit" or None.

    Raises:
        LlakeyError: if there is no such model, it is out of reach, it takes no images, or it cannot be quantised here.
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
        # Left out, code beside the weights would be asked about on the terminal; it is never run.
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
    vars(model.config).pop("auto_map", None)  # code that was not run is not passed on either
    add_stop_token(model, processor)
    return model, processor


def build_from_assets(folder: Path, weights_dtype: str = "float32") -> tuple[PreTrainedModel, Any]:
    """The architecture of a saved pretrained model without its weights, and its processor.

    Args:
        folder: what :func:`save_assets` wrote.
        weights_dtype: "float32" or "bfloat16".

    Raises:
        LlakeyError: if a file is broken, or names code to run.
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
    """Refuse a JSON file of a checkpoint that names code: modules beside it, or kernels of the Hub.

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
        if isinstance(value, dict) and name != "model" and (found := _code(value)):  # a tokenizer's vocabulary is large
            return found
    return ""


def save_assets(folder: Path, model: PreTrainedModel, processor: Any) -> None:
    """Write what rebuilds the architecture and its processor, all but the weights."""
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
