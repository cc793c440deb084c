"""Calibration that is not that of the pictures, or that sees nothing of what the hand goes to."""

from collections.abc import Callable

import numpy as np
import pytest

from fakes import fake_cameras
from lerobot_llakey import schema
from lerobot_llakey.checks.calibration import check_extrinsics, check_intrinsics, check_views
from lerobot_llakey.checks.columns import Columns

SIZES = {"front": (64, 64), "wrist": (64, 64)}


def columns() -> Columns:
    """Ten rows of two fixed cameras that look at where the hand goes to."""
    rng = np.random.default_rng(0)
    intrinsics, extrinsics = fake_cameras(64, 2)
    hand = np.zeros((10, schema.HAND_DIM))
    hand[:, :3], hand[:, 3] = rng.uniform([0.4, -0.1, 0.0], [0.6, 0.1, 0.2], (10, 3)), 1
    values = {schema.ACTION: np.concatenate((hand, np.zeros((10, 1))), axis=1), schema.STATE: hand}
    for number, camera in enumerate(SIZES):
        values[schema.intrinsics_key(camera)] = np.tile(intrinsics[number], (10, 1))
        values[schema.extrinsics_key(camera)] = np.tile(extrinsics[number], (10, 1))
    return Columns(values, {}, hand, hand[:, 8:])


def said(rows: Columns) -> list[str]:
    checks = (check_intrinsics(rows, SIZES), check_extrinsics(rows, list(SIZES)), check_views(rows, SIZES))
    return [finding.expected for findings in checks for finding in findings]


def test_cameras_that_look_at_the_table_are_sound() -> None:
    assert said(columns()) == []


def doubled(rows: Columns) -> None:
    rows[schema.intrinsics_key("front")][:] *= 2


def squeezed(rows: Columns) -> None:
    rows[schema.intrinsics_key("front")][:, 1] *= 2


def at_the_base(rows: Columns) -> None:
    rows[schema.extrinsics_key("front")][:, :3] = 0


def of_the_other(rows: Columns) -> None:
    rows[schema.extrinsics_key("wrist")][:] = rows[schema.extrinsics_key("front")]


def turned_away(rows: Columns) -> None:
    rows[schema.extrinsics_key("front")][:, 3:] = [0, 0, 0, 1]


@pytest.mark.parametrize(
    ("spoil", "expected"),
    [
        (doubled, "a centre of pictures of 64x64"),
        (squeezed, "a centre of pictures of 64x64"),
        (at_the_base, "other than the base's own"),
        (of_the_other, "a place of its own"),
        (turned_away, "that sees where the hand goes"),
    ],
)
def test_what_is_spoilt_is_told(spoil: Callable[[Columns], None], expected: str) -> None:
    rows = columns()
    spoil(rows)
    assert any(expected in text for text in said(rows)), said(rows)
