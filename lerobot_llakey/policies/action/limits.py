"""What the action policy's settings may be."""

from __future__ import annotations

import math
from typing import Protocol

from lerobot_llakey.bounds import (
    AT_LEAST_ONE,
    COUNT,
    POSITIVE,
    SHARE,
    Bounds,
    require_number,
    require_settings,
    require_texts,
)
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.views.cube import longest_edge
from lerobot_llakey.policies.action.views.renderer import VIEWS
from lerobot_llakey.policies.precision import PRECISIONS
from lerobot_llakey.schema import FARTHEST

CHOICES: dict[str, tuple[object, ...]] = {
    "design": ("small", "rvt", "rvt2"),
    "stages": (1, 2),
    "condition_on": ("instruction", "task", "both"),
    "proprioception": ("pose", "gripper", "none"),
    "rotation": ("bins", "sequential_bins", "sixd"),
    "dtype": PRECISIONS,
}
"""What a setting may be."""
FRAMES = ("view", "hand", "base")
_HEADS = 4
"""Of the word encoder's transformer, see :mod:`text.word_encoder`."""

BOUNDS: dict[str, Bounds] = {
    "view_size": Bounds(8, 4096, whole=True),
    "crop_size": POSITIVE,
    "crop_noise": Bounds(),
    "splat_radius": Bounds(0, 16, whole=True, length=2),
    "rotation_blur": Bounds(0, 180),
    "rotation_bins": Bounds(4, 3600, whole=True),
    "text_width": AT_LEAST_ONE,
    "text_layers": AT_LEAST_ONE,
    "text_buckets": AT_LEAST_ONE,
    "text_length": AT_LEAST_ONE,
    "colour_queries": AT_LEAST_ONE,
    "widths": Bounds(1, whole=True, length=3),
    "blocks": Bounds(0, whole=True, length=2),
    "patch_size": AT_LEAST_ONE,
    "token_width": AT_LEAST_ONE,
    "attention_dropout": Bounds(0, 1, open="high"),
    "transformer_layers": AT_LEAST_ONE,
    "transformer_heads": AT_LEAST_ONE,
    "heatmap_sigma_start": POSITIVE,
    "heatmap_sigma_end": POSITIVE,
    "heatmap_shrink_steps": COUNT,
    "augment_translation": Bounds(0, FARTHEST),
    "augment_yaw": Bounds(0, 180),
    "colour_jitter": Bounds(0, 1, open="high"),
    "paraphrase_probability": SHARE,
    "optimizer_lr": POSITIVE,
    "optimizer_weight_decay": Bounds(),
    "optimizer_grad_clip_norm": Bounds(),
}
"""What a number may be."""


class ActionSettings(Protocol):
    """The settings that are checked together; ``LlakeyActionConfig``, which imports this module, has them all."""

    design: str
    views: list[str]
    rotation_frames: list[str]
    workspace: list[list[float]] | str
    view_size: int
    crop_size: float
    crop_noise: float
    widths: list[int]
    patch_size: int
    token_width: int
    transformer_heads: int
    text_width: int


def check_settings(config: ActionSettings) -> None:
    """Refuse settings that make no sense, alone or together.

    Raises:
        LlakeyError: naming what was expected and what came.
    """
    for name, choices in CHOICES.items():
        if (value := getattr(config, name)) not in choices:
            raise LlakeyError(
                f"Expected {name} out of {', '.join(map(repr, choices))}, got {value!r}; pick one of these."
            )
    require_settings(config, BOUNDS)
    _check_views(config)
    _check_network(config)
    edge = math.inf if isinstance(config.workspace, str) else longest_edge(config.workspace)
    require_number("crop_size, within the workspace's longest edge,", config.crop_size, 0, edge)
    require_number("crop_noise, within half of crop_size,", config.crop_noise, 0, config.crop_size / 2)


def _check_views(config: ActionSettings) -> None:
    require_texts("views", config.views, some=True)
    require_texts("rotation_frames", config.rotation_frames, some=True)
    if not set(config.rotation_frames) <= set(FRAMES):
        raise LlakeyError(
            f"Expected rotation_frames out of {', '.join(FRAMES)}, got {config.rotation_frames}; pick one or more."
        )
    if unknown := [name for name in config.views if name not in VIEWS]:
        raise LlakeyError(f"Expected views out of {', '.join(VIEWS)}, got {', '.join(unknown)}; pick some.")
    ordered = [name for name in VIEWS if name in config.views]
    if config.views != ordered:
        raise LlakeyError(
            f"Expected views in the order {', '.join(ordered)}, which the weights follow, got "
            f"{', '.join(config.views)}; put them in order."
        )
    if {axis for name in config.views for axis in VIEWS[name][:2]} != {0, 1, 2}:
        raise LlakeyError(f"Expected views that show x, y and z, got {', '.join(config.views)}; add another view.")


def _check_network(config: ActionSettings) -> None:
    step = 16 if config.design == "small" else config.patch_size
    if config.view_size % step:
        raise LlakeyError(
            f"Expected view_size to be a multiple of {step} for design {config.design!r}, got {config.view_size}; try "
            f"{max(round(config.view_size / step), 1) * step}."
        )
    name, width = ("widths[2]", config.widths[2]) if config.design == "small" else ("token_width", config.token_width)
    if width % config.transformer_heads:
        raise LlakeyError(
            f"Expected transformer_heads that divide {name}, got {config.transformer_heads} and {width}; try 8 and 512."
        )
    if config.text_width % _HEADS:
        raise LlakeyError(f"Expected text_width to be a multiple of {_HEADS}, got {config.text_width}; try 128.")
