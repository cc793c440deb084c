"""Colours that LeRobot moves off their depth are refused by the dataset that was loaded so."""

from pathlib import Path

import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.transforms import ImageTransforms, ImageTransformsConfig

from lerobot_llakey.checks.loader import loaded_datasets, refuse_moved_colours
from lerobot_llakey.errors import LlakeyError


def test_transforms_that_move_pixels_are_refused_and_others_pass(sound: Path) -> None:
    dataset = LeRobotDataset("local/x", root=sound)
    assert loaded_datasets(dataset.meta) == [dataset]
    refuse_moved_colours(dataset.meta)
    dataset.image_transforms = ImageTransforms(ImageTransformsConfig(enable=True))
    with pytest.raises(LlakeyError, match="affine"):
        refuse_moved_colours(dataset.meta)
    colour = {name: one for name, one in ImageTransformsConfig().tfs.items() if one.type != "RandomAffine"}
    dataset.image_transforms = ImageTransforms(ImageTransformsConfig(enable=True, tfs=colour))
    refuse_moved_colours(dataset.meta)
    dataset.image_transforms = None
    dataset._depth_output_unit = "m"
    with pytest.raises(LlakeyError, match="depth_output_unit=m"):
        refuse_moved_colours(dataset.meta)
