"""What a dataset says of itself."""

from typing import Any

import pytest

from lerobot_llakey.hand import names_of


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["x", "y"], ["x", "y"]),
        (None, []),
        ("x", []),
        ({"motors": ["x", "y"]}, ["x", "y"]),
        ({"position": ["x", "y"], "gripper": "open"}, ["x", "y", "open"]),
    ],
)
def test_names_are_read_however_a_recorder_groups_them(names: Any, expected: list[str]) -> None:
    assert names_of({"names": names}) == expected
