"""Settings of the language model: a pretrained one and what of it is trained, or the small one's size."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.bounds import AT_LEAST_ONE, Bounds, require_settings
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.saved.own import names_weights

PARTS = ("vision", "projector", "language")
"""The parts of an image-text model, as named in ``train``."""
ASSETS = "language_model"
"""Folder in a checkpoint with a pretrained model's architecture and processor."""
ADAPTER = "adapter_config.json"
"""File that distinguishes an adapter's folder from a whole checkpoint."""
_SLOTS = ("{system}", "{request}")
_BOUNDS = {
    **dict.fromkeys(("image_size", "patch_size", "vision_width", "vision_layers", "vision_heads"), AT_LEAST_ONE),
    **dict.fromkeys(("text_width", "text_layers", "text_heads"), AT_LEAST_ONE),
    "auxiliary_weight": Bounds(),
}


@dataclass
class ModelSettings:
    """Settings of the command policy's language model.

    Attributes:
        model: Hub name or local folder of a pretrained image-text model (LLaVA, Idefics3/SmolVLM, Qwen-VL, PaliGemma,
            ...); None builds the small model from scratch.
        prompt_format: conversation form of a pretrained model, with the slots ``{system}`` and ``{request}``. None
            takes the processor's chat template, or plain text if it has none; for LLaVA-1.5, whose template would
            separate the images from their descriptions, it takes "{system} USER: {request} ASSISTANT:".
        processor_settings: passed to the processor at every call, such as ``{do_image_splitting: false}`` (SmolVLM,
            Idefics3) or ``{max_pixels: 200704}`` (Qwen-VL).
        train: which parts are trained, out of vision, projector and language. None trains the whole small model, or, as
            in the paper, the projector and the language model of a pretrained one.
        freeze_vision: a short form of ``train``, with or without vision; set only one of the two.
        weights_dtype: precision of the stored weights: "float32" or "bfloat16" (half the memory, but rounding loses
            small updates of the weights; adapters and FSDP keep theirs in float32).
        quantize: "4bit" loads a pretrained model's frozen weights in 4 bits (QLoRA); it needs a CUDA GPU, bitsandbytes,
            and adapters (``--peft.method_type=LORA``) for training. None loads them as they are.
        gradient_checkpointing: recompute activations in the backward pass: less memory, about a third more time.
        image_size: of the small model, pixels a side, to which images are resized. A pretrained model's processor sets
            its own size.
        patch_size: pixels a side of one image token of the small model.
        vision_width, vision_layers, vision_heads: size of the small CLIP vision tower.
        text_width, text_layers, text_heads: size of the small Llama language model.
        auxiliary_weight: weight of the small model's auxiliary loss, which regresses the hand and the next keyframe
            from each sample's state and action. Not in the paper; 0 leaves it out.
    """

    model: str | None = names_weights(lambda saved, folder: _are_read(saved, folder))
    prompt_format: str | None = None
    processor_settings: dict[str, Any] = field(default_factory=dict)
    train: list[str] | None = None
    freeze_vision: bool | None = None
    weights_dtype: str = "float32"
    quantize: str | None = None
    gradient_checkpointing: bool = False

    image_size: int = schema.IMAGE_SIZE
    patch_size: int = 16
    vision_width: int = 192
    vision_layers: int = 4
    vision_heads: int = 6
    text_width: int = 256
    text_layers: int = 4
    text_heads: int = 4
    auxiliary_weight: float = 0.5

    @property
    def trained_parts(self) -> tuple[str, ...]:
        """The trained parts, out of ``PARTS``."""
        if self.train is not None:
            return tuple(part for part in PARTS if part in self.train)
        frozen = self.model is not None if self.freeze_vision is None else self.freeze_vision
        return PARTS[1:] if frozen else PARTS

    def check_model_settings(self) -> None:
        """Refuse impossible or contradictory settings.

        Raises:
            LlakeyError: naming what was expected and what came.
        """
        require_settings(self, _BOUNDS)
        for width, heads in (("vision_width", "vision_heads"), ("text_width", "text_heads")):
            if getattr(self, width) % getattr(self, heads):
                raise LlakeyError(
                    f"Expected {heads} that divide {width}, got {getattr(self, heads)} and {getattr(self, width)}; "
                    "change one of them."
                )
        if self.image_size % self.patch_size:
            raise LlakeyError(
                f"Expected `image_size` to be a multiple of `patch_size`, got {self.image_size} and {self.patch_size}; "
                "change one of them."
            )
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
        if self.prompt_format is not None and not all(slot in self.prompt_format for slot in _SLOTS):
            raise LlakeyError(
                "Expected `prompt_format` with the slots {system} and {request}, got "
                f"{self.prompt_format!r}; write both into it."
            )


def _are_read(saved: Mapping[str, Any], folder: Path) -> bool:
    """Whether a checkpoint loads weights from ``model``: it has none of its own, and it is not a server's model."""
    return saved.get("backend") != "chat" and not (folder / ASSETS).is_dir() and not (folder / ADAPTER).is_file()


def _allowed(value: Any) -> bool:
    """Whether a processor may be passed this: numbers and switches, but no path or address."""
    if isinstance(value, dict):
        return all(_allowed(item) for item in value.values())
    if isinstance(value, list):
        return all(_allowed(item) for item in value)
    return value is None or isinstance(value, (bool, int, float)) or (isinstance(value, str) and value.isidentifier())
