"""Merging datasets: ours is LeRobot's, only faster."""

from pathlib import Path

import numpy as np
import pytest
import torch
from lerobot.datasets.aggregate import aggregate_datasets
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets.image_dataset import ImageDatasetWriter
from lerobot_llakey.datasets.merge import merge
from lerobot_llakey.datasets.plan import Targets

FEATURES = {
    schema.STATE: {"dtype": "float32", "shape": (2,), "names": None},
    schema.intrinsics_key("front"): schema.vector(schema.INTRINSICS_NAMES),
    schema.image_key("front"): {"dtype": "image", "shape": (8, 8, 3), "names": ["height", "width", "channels"]},
}


def dataset(root: Path, tasks: list[str], seed: int) -> Path:
    """Random pictures; one episode a task."""
    rng = np.random.default_rng(seed)
    with ImageDatasetWriter("local/part", root, 10, FEATURES) as writer:
        for task in tasks:
            writer.add_episode(
                [
                    {
                        schema.STATE: rng.normal(size=2).astype(np.float32),
                        schema.intrinsics_key("front"): rng.normal(size=4).astype(np.float32),
                        schema.image_key("front"): rng.integers(0, 256, (8, 8, 3), dtype=np.uint8),
                        schema.TASK: task,
                    }
                    for _ in range(int(rng.integers(2, 6)))
                ]
            )
    return root


def same(first: LeRobotDataset, second: LeRobotDataset) -> None:
    assert len(first) == len(second)
    for index in range(len(first)):
        for key, value in first[index].items():
            other = second[index][key]
            assert torch.equal(value, other) if isinstance(value, torch.Tensor) else value == other, key


def test_merged_pictures_are_what_lerobots_own_merging_gives(tmp_path: Path) -> None:
    parts = [dataset(tmp_path / "a", ["lift", "open", "lift"], 0), dataset(tmp_path / "b", ["close", "open"], 1)]
    merge(parts, tmp_path / "ours", "local/ours")
    theirs_root = tmp_path / "theirs"
    aggregate_datasets(
        ["local/a", "local/b"], "local/theirs", roots=parts, aggr_root=theirs_root, concatenate_data=False
    )
    ours = LeRobotDataset("local/ours", root=tmp_path / "ours")
    theirs = LeRobotDataset("local/theirs", root=theirs_root)
    same(ours, theirs)
    assert [ours.meta.episodes[i]["dataset_to_index"] for i in range(5)] == [
        theirs.meta.episodes[i]["dataset_to_index"] for i in range(5)
    ]
    assert ours.meta.stats is not None and theirs.meta.stats is not None
    np.testing.assert_allclose(ours.meta.stats[schema.STATE]["mean"], theirs.meta.stats[schema.STATE]["mean"])
    assert ours[len(ours) - 1]["task"] == "open"


def test_a_merged_dataset_can_be_merged_again(tmp_path: Path) -> None:
    parts = [dataset(tmp_path / name, ["lift", name], seed) for seed, name in enumerate("abc")]
    merge(parts, tmp_path / "at once", "local/at_once")
    merge(parts[:2], tmp_path / "first", "local/first")
    merge([tmp_path / "first", parts[2]], tmp_path / "in turn", "local/in_turn")
    same(LeRobotDataset("l/x", root=tmp_path / "at once"), LeRobotDataset("l/y", root=tmp_path / "in turn"))


def test_videos_and_texts_survive_lerobots_own_merging(collected: Targets, tmp_path: Path) -> None:
    assert collected.demonstrations is not None
    merge([collected.demonstrations] * 2, tmp_path / "twice", "local/twice")
    once = LeRobotDataset("local/once", root=collected.demonstrations)
    twice = LeRobotDataset("local/twice", root=tmp_path / "twice")
    assert twice.num_episodes == 2 * once.num_episodes
    item, original = twice[len(once) + 20], once[20]
    for key in (schema.image_key("wrist"), schema.depth_key("front"), schema.extrinsics_key("wrist")):
        assert torch.equal(item[key], original[key])
    assert item[schema.INSTRUCTION] == original[schema.INSTRUCTION]


def test_other_features_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = dataset(tmp_path / "a", ["lift"], 0)
    monkeypatch.delitem(FEATURES, schema.STATE)
    second = tmp_path / "b"
    with ImageDatasetWriter("local/part", second, 10, FEATURES) as writer:
        zeros = {schema.intrinsics_key("front"): np.zeros(4, np.float32)}
        writer.add_episode([zeros | {schema.image_key("front"): np.zeros((8, 8, 3), np.uint8), schema.TASK: "lift"}])
    with pytest.raises(ValueError, match=rf"columns of .*a in .*b, which has no {schema.STATE};"):
        merge([first, second], tmp_path / "both", "local/both")
    with pytest.raises(ValueError, match=rf"columns of .*b in .*a, which has also {schema.STATE};"):
        merge([second, first], tmp_path / "both", "local/both")
    assert not (tmp_path / "both").exists()
