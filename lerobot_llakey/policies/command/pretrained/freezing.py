"""What of a pretrained model is trained and what is kept."""

from __future__ import annotations

from transformers import PreTrainedModel


def freeze_vision(model: PreTrainedModel) -> None:
    """Keep the vision tower's weights as they are.

    Raises:
        ValueError: if the model has no part that is known as a vision tower.
    """
    towers = [
        m for name, m in model.named_modules() if name.split(".")[-1] in ("vision_tower", "visual", "vision_model")
    ]
    if not towers:
        raise ValueError(
            f"Expected {type(model).__name__} to have a vision tower, found none; "
            "set freeze_vision=false to train all of it."
        )
    for tower in towers:
        tower.requires_grad_(False)
