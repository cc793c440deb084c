"""What several tests of datasets look at: a small dataset of each kind, collected once."""

from pathlib import Path

import pytest

from lerobot_llakey.datasets.collect import collect
from lerobot_llakey.datasets.plan import CollectSettings, Targets

SETTINGS = CollectSettings(tasks=("open_drawer",), num_episodes=3, split="val", image_size=32)


@pytest.fixture(scope="session")
def collected(tmp_path_factory: pytest.TempPathFactory) -> Targets:
    """Three episodes as demonstrations and keysteps."""
    root = tmp_path_factory.mktemp("collected")
    targets = Targets(root / "demonstrations", root / "keysteps")
    collect(SETTINGS, targets, num_workers=1)
    return targets


@pytest.fixture(scope="session")
def settings() -> CollectSettings:
    """The settings of ``collected``."""
    return SETTINGS


@pytest.fixture
def targets(tmp_path: Path) -> Targets:
    """A place for keysteps alone."""
    return Targets(None, tmp_path / "keysteps")
