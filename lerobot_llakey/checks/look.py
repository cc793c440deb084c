"""A look at a few pictures of the dataset that is about to be trained on."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any

from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.checks.loader import loaded_datasets
from lerobot_llakey.checks.pictures import check_pictures, draw
from lerobot_llakey.files import reading

_FRAMES = 8


def warn_of_pictures(meta: Any, cameras: Sequence[str], workspace: schema.Workspace, name: str) -> None:
    """Log what a handful of pictures tells against calibration and states.

    Videos are left to ``llakey check``: LeRobot's decoders must not run in a process that later forks its loaders.

    Args:
        meta: metadata of the dataset, as LeRobot loaded it.
        cameras: with depth, in the order of the calibration.
        workspace: bounds in metres.
        name: of the dataset.

    Raises:
        LlakeyError: if a picture cannot be read.
    """
    datasets = [dataset for dataset in loaded_datasets(meta) if isinstance(dataset, LeRobotDataset)]
    needed = {schema.STATE, schema.ACTION, schema.INTRINSICS, schema.EXTRINSICS}
    needed |= {key for camera in cameras for key in (schema.image_key(camera), schema.depth_key(camera))}
    if not datasets or meta.video_keys or not needed <= set(meta.features):
        return
    with reading(meta.root, "dataset"):
        sample = draw(datasets[0], cameras, _FRAMES)
    for finding in check_pictures(sample, workspace):
        logging.warning(finding.sentence(name))
