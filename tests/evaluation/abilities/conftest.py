import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes import fake_keysteps


@pytest.fixture(scope="package")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> LeRobotDataset:
    """Three episodes of six frames, all there: like demonstrations."""
    return fake_keysteps(tmp_path_factory.mktemp("keysteps") / "dataset", episodes=3, frames=6, cameras=("front",))
