"""A batch as the command policy's model reads it: the cameras' images and the prompts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.batch import read_hands, read_images
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.pose_text import PoseText
from lerobot_llakey.policies.command.prompt import Prompt
from lerobot_llakey.policies.texts import text_column


def stack_cameras(batch: Mapping[str, Any], keys: Sequence[str]) -> Tensor:
    """The images of a batch as one tensor (B, V, 3, H, W) in 0..1, in the order of ``keys``; the first gives the size.

    Raises:
        LlakeyError: if an image is missing, has another shape than (B, 3, H, W), or colours outside 0..1.
    """
    images = read_images(batch, keys)
    height, width = images[0].shape[-2:]
    resized = [image if image.shape[-2:] == (height, width) else resize(image, (height, width)) for image in images]
    return torch.stack(resized, dim=1)


def resize(images: Tensor, size: tuple[int, int]) -> Tensor:
    """Resize images (N, 3, H, W) to a height and width."""
    return functional.interpolate(images, size=size, mode="bilinear", antialias=True, align_corners=False)


def augment(images: Tensor, shift: int, jitter: float) -> Tensor:
    """Shift each image by a few pixels; change the brightness and contrast of each sample.

    Args:
        images: (B, V, 3, H, W) in 0..1.
        shift: largest shift in pixels in each direction; the border is repeated.
        jitter: largest change of brightness and contrast as a share, the same for all images of a sample.
    """
    batch, cameras, _, height, width = images.shape
    if shift > 0:
        flat = functional.pad(images.flatten(0, 1), (shift,) * 4, mode="replicate")
        offsets = torch.randint(0, 2 * shift + 1, (len(flat), 2)).tolist()
        shifted = [image[:, y : y + height, x : x + width] for image, (y, x) in zip(flat, offsets, strict=True)]
        images = torch.stack(shifted).unflatten(0, (batch, cameras))
    if jitter > 0:
        gain, offset = (torch.rand(2, batch, 1, 1, 1, 1, device=images.device) * 2 - 1) * jitter
        images = ((images - 0.5) * (1 + gain) + 0.5 + offset / 2).clamp(0, 1)
    return images


def read_prompts(
    batch: Mapping[str, Any], config: LlakeyCommandConfig, rng: np.random.Generator | None = None
) -> list[Prompt]:
    """The prompt of each row of a batch.

    Args:
        batch: with ``task`` as a list of str, ``previous_instruction`` if the history is on (a missing one counts as
            none) and ``observation.state`` if proprioception is on.
        config: decides what the prompt contains.
        rng: draws in training which rows hide the previous instruction; None hides none.

    Raises:
        LlakeyError: if the task or the state is missing, or wrong in a row.
    """
    tasks = text_column(batch, schema.TASK)
    states: Sequence[str | None] = _hand_texts(batch, config) if config.uses_proprioception else [None] * len(tasks)
    previous: Sequence[str | None] = [None] * len(tasks)
    if config.history and config.target == "instruction":
        none = [""] * len(tasks)
        previous = text_column(batch, schema.PREVIOUS_INSTRUCTION, len(tasks), default=none, may_be_empty=True)
        if rng is not None:
            hidden = rng.random(len(tasks)) < config.history_dropout
            previous = ["" if hide else text for hide, text in zip(hidden, previous, strict=True)]
    return [Prompt(tuple(config.cameras), *row) for row in zip(tasks, previous, states, strict=True)]


def _hand_texts(batch: Mapping[str, Any], config: LlakeyCommandConfig) -> list[str]:
    """The hand of each row as numbers."""
    if schema.STATE not in batch:
        raise LlakeyError(
            f"Expected {schema.STATE!r} in the batch for proprioception=pose, got {sorted(batch)}; use a dataset or an "
            "environment that has it."
        )
    text = PoseText(config.action_bins, config.box)
    return [text.encode_hand(hand) for hand in read_hands(batch, config.hand_columns).double().cpu().numpy()]
