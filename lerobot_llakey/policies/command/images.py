"""Images on their way to the model: collecting the views, small random changes, normalisation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import torch
from torch import Tensor
from torch.nn import functional

from lerobot_llakey.policies.batch import read_images


def stack_views(batch: Mapping[str, Any], keys: Sequence[str]) -> Tensor:
    """The views of a batch as one tensor (B, V, 3, H, W) in 0..1, in the order of ``keys``.

    Raises:
        LlakeyError: if an image is missing, has another shape than (B, 3, H, W), or colours outside 0..1.
    """
    images = read_images(batch, keys)
    height, width = images[0].shape[-2:]
    alike = [image if image.shape[-2:] == (height, width) else resize(image, (height, width)) for image in images]
    return torch.stack(alike, dim=1)


def resize(images: Tensor, size: tuple[int, int]) -> Tensor:
    """Images (N, 3, H, W) at another height and width."""
    return functional.interpolate(images, size=size, mode="bilinear", antialias=True, align_corners=False)


def augment(images: Tensor, shift: int, jitter: float) -> Tensor:
    """Shift each image by a few pixels and scale the brightness and contrast of each sample.

    Args:
        images: (B, V, 3, H, W) in 0..1.
        shift: pixels each way at most; the border is repeated.
        jitter: share by which brightness and contrast change at most; all views of a sample change alike.
    """
    batch, views, _, height, width = images.shape
    if shift > 0:
        flat = functional.pad(images.flatten(0, 1), (shift,) * 4, mode="replicate")
        offsets = torch.randint(0, 2 * shift + 1, (len(flat), 2)).tolist()
        shifted = [image[:, y : y + height, x : x + width] for image, (y, x) in zip(flat, offsets, strict=True)]
        images = torch.stack(shifted).unflatten(0, (batch, views))
    if jitter > 0:
        gain, offset = (torch.rand(2, batch, 1, 1, 1, 1, device=images.device) * 2 - 1) * jitter
        images = ((images - 0.5) * (1 + gain) + 0.5 + offset / 2).clamp(0, 1)
    return images
