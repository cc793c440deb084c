"""Loads a pretrained image-text model with its processor, and rebuilds one from a checkpoint."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch
from transformers import AutoConfig, AutoModelForImageTextToText, AutoProcessor, PreTrainedModel

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.pretrained.quantization import quantized_loading
from lerobot_llakey.policies.command.pretrained.stop_token import add_stop_token

ASSETS = "language_model"
"""Folder inside a checkpoint that rebuilds a pretrained model's architecture and processor."""

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
        ValueError: if there is no such model, it is out of reach, it takes no images, or it cannot be quantised here.
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
        config = AutoConfig.from_pretrained(source)
        if type(config) not in AutoModelForImageTextToText._model_mapping:
            raise LlakeyError(
                f"Expected `model` to take images and text, got {name!r}, a {config.model_type} model that does not; "
                "name an image-text model."
            )
        processor = AutoProcessor.from_pretrained(source)
        model = AutoModelForImageTextToText.from_pretrained(source, **options)
    except (OSError, ValueError, KeyError, ImportError) as error:
        raise LlakeyError(_reason(name, error)) from error
    if not hasattr(processor, "image_processor"):
        raise LlakeyError(
            f"Expected `model` with a processor of images and text, got {name!r} with a {type(processor).__name__}; "
            "save the model's processor beside it."
        )
    add_stop_token(model, processor)
    return model, processor


def build_from_assets(folder: Path, weights_dtype: str = "float32") -> tuple[PreTrainedModel, Any]:
    """The architecture of a saved pretrained model without its weights, and its processor.

    Args:
        folder: what :func:`save_assets` wrote.
        weights_dtype: "float32" or "bfloat16".
    """
    processor = AutoProcessor.from_pretrained(folder)
    config = AutoConfig.from_pretrained(folder)
    model = AutoModelForImageTextToText.from_config(config, dtype=getattr(torch, weights_dtype))
    add_stop_token(model, processor)
    return model, processor


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
    if isinstance(error, ImportError):
        return f"Expected the packages that the model {name!r} needs, got a machine without one; install it: {first}"
    return f"Expected `model` to name an image-text model with its processor, got {name!r} ({first}); check the name."
