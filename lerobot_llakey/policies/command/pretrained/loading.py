"""Loads a pretrained image-text model with its processor, and rebuilds one from a checkpoint."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch
from transformers import AutoConfig, AutoModelForImageTextToText, AutoProcessor, PreTrainedModel

from lerobot_llakey.policies.command.pretrained.stop_token import add_stop_token

ASSETS = "language_model"
"""Folder inside a checkpoint that rebuilds a pretrained model's architecture and processor."""


def load_pretrained(name: str) -> tuple[PreTrainedModel, Any]:
    """A pretrained image-text model and its processor, taught the stop token where it is lacking.

    Args:
        name: Hub name or local folder.

    Returns:
        The model in float32 and its processor.

    Raises:
        ValueError: if there is no such model, or it is not one of images and text.
    """
    looks_local = name.startswith((".", "/", "~")) or name.count("/") > 1
    path = Path(name).expanduser()
    if looks_local and not path.is_dir():
        raise ValueError(
            f"Expected `model` to be a folder or a Hub name, got {name!r}, which does not exist; check the path."
        )
    source = str(path) if path.is_dir() else name
    try:
        processor = AutoProcessor.from_pretrained(source)
        model = AutoModelForImageTextToText.from_pretrained(source, dtype=torch.float32)
    except (OSError, ValueError, KeyError) as error:
        reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise ValueError(
            f"Expected `model` to name an image-text model with its processor, got {name!r} ({reason}); check the name."
        ) from error
    add_stop_token(model, processor)
    return model, processor


def build_from_assets(folder: Path) -> tuple[PreTrainedModel, Any]:
    """The architecture of a saved pretrained model without its weights, and its processor.

    Args:
        folder: what :func:`save_assets` wrote.
    """
    processor = AutoProcessor.from_pretrained(folder)
    model = AutoModelForImageTextToText.from_config(AutoConfig.from_pretrained(folder), dtype=torch.float32)
    add_stop_token(model, processor)
    return model, processor


def save_assets(folder: Path, model: PreTrainedModel, processor: Any) -> None:
    """Write what rebuilds the architecture and its processor, all but the weights."""
    folder.mkdir(parents=True, exist_ok=True)
    model.config.save_pretrained(folder)
    processor.save_pretrained(folder)
