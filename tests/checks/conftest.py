"""A sound dataset that tests of checks spoil."""

from pathlib import Path

import pytest

from fakes import fake_keysteps


@pytest.fixture(scope="session")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two episodes of six frames, whole recordings."""
    return fake_keysteps(tmp_path_factory.mktemp("checks") / "sound", image_size=16).root
