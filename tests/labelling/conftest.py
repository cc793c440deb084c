"""The episodes that are labelled."""

import pytest

from fakes_found import three_episodes
from lerobot_llakey.datasets.found import FoundKeyframes


@pytest.fixture
def found() -> list[FoundKeyframes]:
    return three_episodes()
