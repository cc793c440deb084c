"""A look at a few pictures of the dataset that is about to be trained on."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any

from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.checks.loader import loaded_datasets
from lerobot_llakey.checks.pictures import check_pictures, draw, pictured
from lerobot_llakey.files import reading

_FRAMES = 8


def warn_of_pictures(meta: Any, cameras: Sequence[str], workspace: schema.Workspace | None, name: str) -> None:
    """Log what a handful of pictures tells against calibration and states.

    Videos are left to ``llakey check``: LeRobot's decoders must not run in a process that later forks its loaders.

    Args:
        meta: metadata of the dataset, as LeRobot loaded it.
        cameras: with depth and calibration.
        workspace: bounds in metres; None for where the hand goes to.
        name: of the dataset.

    Raises:
        LlakeyError: if a picture cannot be read.
    """
    datasets = [dataset for dataset in loaded_datasets(meta) if isinstance(dataset, LeRobotDataset)]
    if not datasets or meta.video_keys or not cameras or not pictured(cameras) <= set(meta.features):
        return
    with reading(meta.root, "dataset"):
        sample = draw(datasets[0], cameras, _FRAMES)
    for finding in check_pictures(sample, workspace):
        logging.warning(finding.sentence(name))
