"""What of an image-text model is trained and what is kept."""

from __future__ import annotations

import re
from collections.abc import Sequence

from torch import nn

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.pretrained.settings import PARTS

_PROJECTOR = re.compile(r"(^|\.)(multi_modal_projector|connector|aligner|image_newline|[a-z_]*merger[a-z_]*)(\.|$)")
_VISION = re.compile(r"(^|\.)(vision_tower|vision_model|visual)(\.|$)")


def part_of(name: str) -> str:
    """The part, out of ``PARTS``, that a parameter or module of an image-text model belongs to.

    Args:
        name: its name within the model. The projector of Qwen-VL ("visual.merger") stands inside its vision tower.
    """
    if _PROJECTOR.search(name):
        return "projector"
    return "vision" if _VISION.search(name) else "language"


def train_parts(model: nn.Module, trained: Sequence[str]) -> None:
    """Let gradients flow into some parts of a model alone.

    Args:
        model: an image-text model of transformers.
        trained: the parts, out of ``PARTS``.

    Raises:
        LlakeyError: if the model lacks a part that has to be told apart.
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
