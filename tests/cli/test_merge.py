from pathlib import Path

import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes import fake_keysteps
from lerobot_llakey.cli.merge import MergeConfig, run


def test_datasets_are_joined_in_order_and_may_count_twice(tmp_path: Path) -> None:
    sources = [fake_keysteps(tmp_path / name, episodes=count, image_size=32) for name, count in (("a", 2), ("b", 1))]
    run(MergeConfig(f"{tmp_path / 'a'}, {tmp_path / 'b'},{tmp_path / 'b'}", tmp_path / "both"))
    both = LeRobotDataset("local/both", root=tmp_path / "both")
    assert both.meta.total_episodes == 4
    assert len(both) == len(sources[0]) + 2 * len(sources[1])


def test_wrong_folders_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"none at .*nowhere"):
        run(MergeConfig(str(tmp_path / "nowhere"), tmp_path / "both"))
    fake_keysteps(tmp_path / "a", episodes=1, image_size=32)
    with pytest.raises(FileExistsError, match="choose another --root"):
        run(MergeConfig(str(tmp_path / "a"), tmp_path / "a"))
