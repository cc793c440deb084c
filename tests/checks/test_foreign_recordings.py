"""Recordings of other arms, with noise and pauses, pass the checks; what is wrong with them does not."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from lerobot.datasets.dataset_metadata import LeRobotDatasetMetadata
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes_recordings import fake_demonstrations
from fakes_wrong import Rows, wrong_dataset
from lerobot_llakey import schema
from lerobot_llakey.checks.dataset import find, needs_all
from lerobot_llakey.checks.pictures import check_pictures, draw

TOP, SIDE = schema.extrinsics_key("top"), schema.extrinsics_key("side")


@pytest.fixture(scope="module")
def demonstrations(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of five joints, with two cameras of different sizes."""
    return fake_demonstrations(tmp_path_factory.mktemp("arm"), "five_joints", scale=0.1).root


def spoilt_pictures(root: Path) -> list[str]:
    dataset = LeRobotDataset("me/arm", root=root)
    sample = draw(dataset, schema.cameras_of(dataset.features, depth=True))
    return [finding.sentence("it") for finding in check_pictures(sample)]


def test_pictures_of_different_sizes_give_no_warning(demonstrations: Path) -> None:
    assert spoilt_pictures(demonstrations) == []


def test_swapped_extrinsics_are_told_by_the_pictures(demonstrations: Path, tmp_path: Path) -> None:
    def swap(rows: Rows) -> None:
        rows[TOP], rows[SIDE] = rows[SIDE].copy(), rows[TOP].copy()

    said = " ".join(spoilt_pictures(wrong_dataset(demonstrations, tmp_path / "wrong", swap)))
    assert "stands where camera side does" in said and "stands where camera top does" in said


def millimetres(rows: Rows) -> None:
    rows[schema.STATE][:, :3] *= 1000


def w_first(rows: Rows) -> None:
    rows[schema.STATE][:, 3:7] = np.roll(rows[schema.STATE][:, 3:7], 1, axis=1)


def full_size(rows: Rows) -> None:
    rows[schema.intrinsics_key("side")] *= 10


def percent(rows: Rows) -> None:
    rows[schema.STATE][:, 7] *= 100


def metres_open(rows: Rows) -> None:
    rows[schema.STATE][:, 7] *= 0.07


@pytest.mark.parametrize(
    ("change", "column"),
    [
        (millimetres, schema.STATE),
        (w_first, schema.ACTION),
        (full_size, schema.intrinsics_key("side")),
        (percent, schema.STATE),
        (metres_open, schema.STATE),
    ],
)
def test_what_is_wrong_is_refused(
    change: Callable[[Rows], None], column: str, demonstrations: Path, tmp_path: Path
) -> None:
    meta = LeRobotDatasetMetadata("me/arm", root=wrong_dataset(demonstrations, tmp_path / "wrong", change))
    assert column in {finding.column for finding in find(meta, needs_all(meta.features)) if finding.certain}
