"""Settings of a pretrained model: which, how it is loaded, what of it is trained."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.saved.own import names_weights

PARTS = ("vision", "projector", "language")
"""The parts of an image-text model, as they are named in ``train``."""
ASSETS = "language_model"
"""Folder inside a checkpoint that rebuilds a pretrained model's architecture and processor."""
ADAPTER = "adapter_config.json"
"""File that tells an adapter's folder from a whole checkpoint."""


@dataclass
class PretrainedModelSettings:
    """Settings of the model that the command policy starts from.

    Attributes:
        model: Hub name or local folder of a pretrained image-text model (LLaVA, Idefics3/SmolVLM, Qwen-VL, PaliGemma,
            ...); None builds the small model from scratch.
        prompt_format: conversation form of a pretrained model, with the slots ``{system}`` and ``{request}``. None
            takes the chat template of the model's processor; for LLaVA-1.5, whose template would move the images away
            from their descriptions, "{system} USER: {request} ASSISTANT:"; and plain text where there is no template.
        processor_settings: given to the processor at every call, such as ``{do_image_splitting: false}`` (SmolVLM,
            Idefics3) or ``{max_pixels: 200704}`` (Qwen-VL).
        train: what is trained, out of vision, projector and language. None trains all of the small model, and the
            projector and the language model of a pretrained one, as the paper does.
        freeze_vision: shorter for ``train`` with or without vision; give one of the two.
        weights_dtype: precision in which weights are kept: "float32" or "bfloat16" (half the memory; small updates of
            weights trained in it get lost in rounding, adapters and FSDP keep theirs in float32).
        quantize: "4bit" loads a pretrained model's frozen weights in 4 bits (QLoRA), which needs a CUDA GPU and
            bitsandbytes, and adapters (``--peft.method_type=LORA``) to train; None does not.
        gradient_checkpointing: compute activations anew in the backward pass: less memory, about a third more time.
    """

    model: str | None = names_weights(lambda saved, folder: _are_read(saved, folder))
    prompt_format: str | None = None
    processor_settings: dict[str, Any] = field(default_factory=dict)
    train: list[str] | None = None
    freeze_vision: bool | None = None
    weights_dtype: str = "float32"
    quantize: str | None = None
    gradient_checkpointing: bool = False

    @property
    def trained_parts(self) -> tuple[str, ...]:
        """What is trained, out of ``PARTS``."""
        if self.train is not None:
            return tuple(part for part in PARTS if part in self.train)
        frozen = self.model is not None if self.freeze_vision is None else self.freeze_vision
        return PARTS[1:] if frozen else PARTS

    def check_model_settings(self) -> None:
        """Refuse settings that contradict one another.

        Raises:
            LlakeyError: naming what was expected and what came.
        """
        if self.train is not None and (not self.train or set(self.train) - set(PARTS)):
            raise LlakeyError(f"Expected `train` to list some of {list(PARTS)}, got {self.train}; name what to train.")
        if self.train is not None and self.freeze_vision is not None:
            raise LlakeyError(
                f"Expected one of `train` and `freeze_vision`, got train={self.train} and "
                f"freeze_vision={self.freeze_vision}; leave freeze_vision out."
            )
        fed = sorted({"text", "images", "videos", "audio"} & set(self.processor_settings))
        if fed or not _allowed(self.processor_settings):
            raise LlakeyError(
                "Expected `processor_settings` of numbers, switches and single words, got "
                f"{fed or self.processor_settings}; what a processor reads comes from the batch alone."
            )
        if self.weights_dtype not in ("float32", "bfloat16"):
            raise LlakeyError(
                f"Expected `weights_dtype` float32 or bfloat16, got {self.weights_dtype!r}; choose one of them."
            )
        if self.quantize not in (None, "4bit"):
            raise LlakeyError(f"Expected `quantize` 4bit or null, got {self.quantize!r}; choose one of them.")
        if self.quantize and self.model is None:
            raise LlakeyError("Expected a pretrained `model` with quantize=4bit, got none; name one.")
        if self.prompt_format is not None and not {"{system}", "{request}"} <= set(_slots(self.prompt_format)):
            raise LlakeyError(
                "Expected `prompt_format` with the slots {system} and {request}, got "
                f"{self.prompt_format!r}; write both into it."
            )


def _are_read(saved: Mapping[str, Any], folder: Path) -> bool:
    """Whether a checkpoint's weights come from ``model``: not a server's, not where they stand in the checkpoint."""
    return saved.get("backend") != "chat" and not (folder / ASSETS).is_dir() and not (folder / ADAPTER).is_file()


def _allowed(value: Any) -> bool:
    """Whether a processor can be told this: numbers and switches, nothing that names a place."""
    if isinstance(value, dict):
        return all(_allowed(item) for item in value.values())
    if isinstance(value, list):
        return all(_allowed(item) for item in value)
    return value is None or isinstance(value, (bool, int, float)) or (isinstance(value, str) and value.isidentifier())


def _slots(text: str) -> list[str]:
    return [slot for slot in ("{system}", "{request}") if slot in text]
