"""What the command policy's settings may be."""

from __future__ import annotations

from typing import Any

from lerobot_llakey.bounds import AT_LEAST_ONE, COUNT, SHARE, Bounds, require_settings, require_texts
from lerobot_llakey.errors import LlakeyError

_SHOWN = 5
BOUNDS: dict[str, Bounds] = {
    "history_dropout": SHARE,
    "image_size": AT_LEAST_ONE,
    "patch_size": AT_LEAST_ONE,
    "vision_width": AT_LEAST_ONE,
    "vision_layers": AT_LEAST_ONE,
    "vision_heads": AT_LEAST_ONE,
    "text_width": AT_LEAST_ONE,
    "text_layers": AT_LEAST_ONE,
    "text_heads": AT_LEAST_ONE,
    "auxiliary_weight": Bounds(),
    "action_bins": Bounds(2, 1000, whole=True),
    "hold_above": Bounds(0, open="low", optional=True),
    "max_new_tokens": Bounds(2, 4096, whole=True),
    "shift_pixels": COUNT,
    "colour_jitter": Bounds(0, 1, open="high"),
    "paraphrase_probability": SHARE,
    "optimizer_lr": Bounds(0, open="low", optional=True),
    "optimizer_weight_decay": Bounds(),
    "optimizer_grad_clip_norm": Bounds(),
}
"""What a number may be."""


def check_numbers(config: Any) -> None:
    """Refuse numbers that make no sense.

    Raises:
        LlakeyError: naming what was expected and what came.
    """
    require_settings(config, BOUNDS)
    for width, heads in (("vision_width", "vision_heads"), ("text_width", "text_heads")):
        if getattr(config, width) % getattr(config, heads):
            raise LlakeyError(
                f"Expected {heads} that divide {width}, got {getattr(config, heads)} and {getattr(config, width)}; "
                "change one of them."
            )


def check_texts(config: Any) -> None:
    """Refuse a vocabulary out of order, and known answers that are no basic actions.

    Raises:
        LlakeyError: naming what was expected and what came.
    """
    require_texts("words", config.words)
    require_texts("instructions", config.instructions)
    if config.words != sorted(config.words):
        raise LlakeyError(
            "Expected words in alphabetical order, in which the weights know them, got "
            f"{', '.join(config.words[:_SHOWN])}, ...; take the checkpoint's own or sort them."
        )
    wrong = [text for text in config.instructions if not config.rules.is_parsable(text)]
    if config.target == "instruction" and wrong:
        raise LlakeyError(
            f"Expected instructions of {config.rules.name}, got {len(wrong)} outside it "
            f"({', '.join(repr(text[:60]) for text in wrong[:_SHOWN])}), which would never be carried "
            "out; reword them, add a template, or choose --policy.grammar=free."
        )
