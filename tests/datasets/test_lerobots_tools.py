"""LeRobot's own tools for editing and viewing datasets take ours, of both kinds, and keep what they say."""

from pathlib import Path

import numpy as np
import pytest
import torch
from lerobot.datasets.dataset_tools import delete_episodes, merge_datasets, remove_feature, split_dataset
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets.plan import Targets
from lerobot_llakey.grammar import of_features

KINDS = ("demonstrations", "keysteps")
_PLACES = {"index", "episode_index", "task_index"}
"""Columns that say where a frame stands in the whole dataset."""


@pytest.fixture(params=KINDS)
def source(request: pytest.FixtureRequest, collected: Targets) -> LeRobotDataset:
    """Three episodes."""
    root = {"demonstrations": collected.demonstrations, "keysteps": collected.keysteps}[request.param]
    return LeRobotDataset(f"local/{request.param}", root=root)


def rows(dataset: LeRobotDataset, episode: int) -> dict[str, np.ndarray]:
    """All columns of an episode without pictures."""
    table = dataset.hf_dataset.with_format("numpy")
    of = np.flatnonzero(np.array(table["episode_index"]) == episode)
    return {key: np.array(table[key])[of] for key in table.column_names if key not in dataset.meta.camera_keys}


def assert_same_episodes(
    made: LeRobotDataset, source: LeRobotDataset, episodes: list[int], without: frozenset[str] = frozenset()
) -> None:
    """The made dataset holds these episodes of the source, frame for frame."""
    assert made.num_episodes == len(episodes)
    assert (
        of_features(made.features, schema.INSTRUCTION).to_data() == made.features[schema.INSTRUCTION]["info"]["grammar"]
    )
    assert made.meta.stats is not None and source.meta.stats is not None
    assert set(made.meta.stats) == set(source.meta.stats) - without
    first = 0
    for episode, original in enumerate(episodes):
        after, before = rows(made, episode), rows(source, original)
        assert set(after) == set(before) - without
        for key in set(after) - _PLACES:
            np.testing.assert_array_equal(after[key], before[key], err_msg=key)
        np.testing.assert_array_equal(after["index"], first + np.arange(len(after["index"])))
        assert after[schema.NEXT_KEYFRAME].max() == before[schema.NEXT_KEYFRAME].max() < 200, "counted in the episode"
        begin = int(source.meta.episodes[original]["dataset_from_index"])
        shown, recorded = made[first], source[begin]
        assert shown[schema.TASK] == recorded[schema.TASK]
        for camera in schema.CAMERAS:
            np.testing.assert_array_equal(shown[schema.depth_key(camera)], recorded[schema.depth_key(camera)])
        first += len(after["index"])


def test_episodes_are_deleted(source: LeRobotDataset, tmp_path: Path) -> None:
    assert_same_episodes(delete_episodes(source, [1], tmp_path / "left", "local/left"), source, [0, 2])


def test_datasets_are_split(source: LeRobotDataset, tmp_path: Path) -> None:
    parts = split_dataset(source, {"train": [0, 2], "val": [1]}, tmp_path)
    assert_same_episodes(parts["train"], source, [0, 2])
    assert_same_episodes(parts["val"], source, [1])


@pytest.mark.slow
def test_datasets_are_merged(source: LeRobotDataset, tmp_path: Path) -> None:
    assert_same_episodes(
        merge_datasets([source, source], "local/twice", tmp_path / "twice"), source, [0, 1, 2, 0, 1, 2]
    )


@pytest.mark.slow
def test_features_are_removed(source: LeRobotDataset, tmp_path: Path) -> None:
    gone = [schema.VELOCITY, schema.image_key("wrist"), schema.EPISODE_EVENT]
    made = remove_feature(source, gone, tmp_path / "without", "local/without")
    assert set(source.features) - set(made.features) == set(gone)
    assert_same_episodes(made, source, [0, 1, 2], frozenset(gone))


@pytest.mark.slow
def test_what_tools_made_can_be_edited_again(source: LeRobotDataset, tmp_path: Path) -> None:
    left = delete_episodes(source, [0], tmp_path / "left", "local/left")
    both = merge_datasets([left, source], "local/both", tmp_path / "both")
    again = delete_episodes(both, [1], tmp_path / "again", "local/again")
    assert_same_episodes(again, source, [1, 0, 1, 2])


def test_frames_are_batched_as_lerobots_viewer_does(source: LeRobotDataset) -> None:
    batch = next(iter(torch.utils.data.DataLoader(source, batch_size=4)))
    assert len(batch[schema.INSTRUCTION]) == len(batch[schema.STATE]) == 4
