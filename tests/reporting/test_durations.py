import pytest

from lerobot_llakey.reporting.durations import clock


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.4, "0 s"), (12, "12 s"), (89.4, "89 s"), (90, "2 min"), (600, "10 min"), (5340, "89 min"), (5400, "1.5 h")],
)
def test_durations_in_words(seconds: float, words: str) -> None:
    assert clock(seconds) == words
