from pathlib import Path

import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes import fake_keysteps
from lerobot_llakey.cli.merge import MergeConfig, run
from lerobot_llakey.datasets import merge as merging
from lerobot_llakey.errors import FileInTheWayError, LlakeyError, MissingFileError


def test_datasets_are_joined_in_order_and_may_count_twice(tmp_path: Path) -> None:
    sources = [fake_keysteps(tmp_path / name, episodes=count, image_size=32) for name, count in (("a", 2), ("b", 1))]
    run(MergeConfig(f"{tmp_path / 'a'}, {tmp_path / 'b'},{tmp_path / 'b'}", tmp_path / "both"))
    both = LeRobotDataset("local/both", root=tmp_path / "both")
    assert both.meta.total_episodes == 4
    assert len(both) == len(sources[0]) + 2 * len(sources[1])


def test_wrong_folders_are_named(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"dataset at .*nowhere"):
        run(MergeConfig(str(tmp_path / "nowhere"), tmp_path / "both"))
    with pytest.raises(LlakeyError, match="--roots"):
        run(MergeConfig(" , ", tmp_path / "both"))
    fake_keysteps(tmp_path / "a", episodes=1, image_size=32)
    with pytest.raises(FileInTheWayError, match="choose another"):
        run(MergeConfig(str(tmp_path / "a"), tmp_path / "a"))


@pytest.mark.parametrize("point", ["_copy_data", "aggregate_metadata", "finalize_aggregation"])
def test_a_killed_run_leaves_no_half_dataset_and_does_not_block_the_next(
    point: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def killed(*_: object) -> None:
        raise KeyboardInterrupt

    fake_keysteps(tmp_path / "a", episodes=1, image_size=32)
    config = MergeConfig(str(tmp_path / "a"), tmp_path / "both")
    with monkeypatch.context() as patch:
        patch.setattr(merging, point, killed)
        patch.setattr("lerobot_llakey.folders.remove", lambda path: None)  # a killed process cleans up nothing
        with pytest.raises(KeyboardInterrupt):
            run(config)
    assert not (tmp_path / "both").exists()
    run(config)
    assert LeRobotDataset("local/both", root=tmp_path / "both").meta.total_episodes == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "both"]
