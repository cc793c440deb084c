"""How LeRobot loads the dataset that is trained on, which its metadata alone does not tell."""

from __future__ import annotations

import gc
from typing import Any

from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.datasets.streaming_dataset import StreamingLeRobotDataset
from lerobot.transforms import ImageTransforms
from torch import nn
from torchvision.transforms import v2

from lerobot_llakey.errors import LlakeyError

_STAYING = ("ColorJitter", "SharpnessJitter", "Identity", "GaussianBlur", "RandomGrayscale", "RandomAutocontrast")
"""Transforms that leave every point of a picture in its place."""


def loaded_datasets(meta: Any) -> list[Any]:
    """The datasets in this process that were loaded with this metadata.

    LeRobot hands a policy the metadata of its dataset and nothing that tells how pictures are transformed on the way:
    not in its settings, not in the metadata, not in a batch. The dataset itself is alive, though, and holds the very
    same metadata.
    """
    kinds = (LeRobotDataset, StreamingLeRobotDataset)
    # By type and not by isinstance, which is slow over a million objects and asks lazy ones for their class.
    return [
        thing for thing in gc.get_objects() if issubclass(type(thing), kinds) and thing.__dict__.get("meta") is meta
    ]


def refuse_moved_colours(meta: Any) -> None:
    """Refuse transforms that move colours but not the depth that belongs to them, and depth in metres.

    LeRobot applies its image transforms to colour alone, one camera after the other. Its defaults hold an affine one,
    which moves colours by up to six pixels off their points.

    Args:
        meta: metadata of the dataset to train on.

    Raises:
        LlakeyError: if the dataset is loaded so.
    """
    for dataset in loaded_datasets(meta):
        moving = _moving(getattr(dataset, "image_transforms", None))
        if moving:
            raise LlakeyError(
                "Expected image transforms that leave pixels in their place, as depth stays where it is, got "
                f"{', '.join(moving)} in dataset.image_transforms; set dataset.image_transforms.enable=false, or give "
                "dataset.image_transforms.tfs without them."
            )
        unit = getattr(dataset, "_depth_output_unit", "mm")
        if unit != "mm":
            raise LlakeyError(f"Expected depth in millimetres, got dataset.depth_output_unit={unit}; set it to mm.")


def _moving(transforms: Any) -> list[str]:
    """Names of the transforms that move pixels; a callable of unknown making is trusted."""
    if isinstance(transforms, ImageTransforms):
        if isinstance(transforms.tf, v2.Identity):
            return []
        return [name for name, one in transforms.transforms.items() if type(one).__name__ not in _STAYING]
    parts = list(transforms.modules()) if isinstance(transforms, nn.Module) else []
    geometric = (v2.RandomAffine, v2.RandomRotation, v2.RandomPerspective, v2.RandomCrop, v2.RandomResizedCrop)
    flips = (v2.RandomHorizontalFlip, v2.RandomVerticalFlip, v2.ElasticTransform)
    return [type(part).__name__ for part in parts if isinstance(part, (*geometric, *flips))]
