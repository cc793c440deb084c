"""A finding is one sentence, with its numbers as a person reads them."""

import numpy as np
import pytest

from lerobot_llakey.checks.finding import Finding, Place, told


@pytest.mark.parametrize(
    ("numbers", "expected"),
    [
        (np.array([0.5, 1 / 3, 1e9]), "[0.5, 0.3333, 1e+09]"),
        (np.array([[1.0, 0.0], [0.0, np.nan]], dtype=np.float32), "[[1, 0], [0, nan]]"),
    ],
)
def test_numbers_are_told_in_four_figures(numbers: np.ndarray, expected: str) -> None:
    assert told(numbers) == expected


def test_a_finding_says_what_where_and_what_to_do() -> None:
    finding = Finding("action", "finite numbers", "nan", "drop these rows", Place("episode 1, frame 2", 1, 2))
    assert finding.sentence("mine") == (
        "Expected finite numbers in action of mine, got nan at episode 1, frame 2; drop these rows."
    )
