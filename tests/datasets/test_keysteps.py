"""Keysteps drawn from demonstrations."""

from pathlib import Path

import numpy as np
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets.balance import Balance
from lerobot_llakey.datasets.keysteps import convert
from lerobot_llakey.datasets.plan import Targets


def test_keysteps_of_demonstrations_are_their_frames(collected: Targets, tmp_path: Path) -> None:
    source = LeRobotDataset("local/demonstrations", root=collected.demonstrations)
    count = convert(source, tmp_path / "keysteps", "local/keysteps", seed=1)
    keysteps = LeRobotDataset("local/keysteps", root=tmp_path / "keysteps")
    assert len(keysteps) == count < len(source)
    assert keysteps.num_episodes == source.num_episodes
    shown = set(schema.dataset_features())
    assert shown <= set(keysteps.features)
    # The first sample of each episode is its first frame.
    for episode in range(source.num_episodes):
        sample = keysteps[int(keysteps.meta.episodes[episode]["dataset_from_index"])]
        frame = source[int(source.meta.episodes[episode]["dataset_from_index"])]
        for key in (
            schema.STATE,
            schema.ACTION,
            schema.intrinsics_key("wrist"),
            schema.extrinsics_key("wrist"),
            schema.EPISODE_SEED,
        ):
            np.testing.assert_array_equal(sample[key], frame[key])
        for key in (schema.INSTRUCTION, schema.PREVIOUS_INSTRUCTION, schema.TASK):
            assert sample[key] == frame[key]
        np.testing.assert_allclose(sample[schema.image_key("front")], frame[schema.image_key("front")], atol=1e-6)
        np.testing.assert_array_equal(sample[schema.depth_key("wrist")], frame[schema.depth_key("wrist")])


def test_weighed_keysteps_say_what_they_count(collected: Targets, tmp_path: Path) -> None:
    source = LeRobotDataset("local/demonstrations", root=collected.demonstrations)
    balance = Balance("weight", stride=20, keyframe_repeats=4)
    convert(source, tmp_path / "keysteps", "local/keysteps", balance=balance)
    rows = LeRobotDataset("local/keysteps", root=tmp_path / "keysteps").hf_dataset.with_format("numpy")
    weights = np.asarray(rows[schema.SAMPLE_WEIGHT]).ravel()
    begins = np.asarray(rows[schema.IS_KEYFRAME]).ravel() | (np.asarray(rows[schema.PREVIOUS_INSTRUCTION]) == "")
    np.testing.assert_array_equal(weights, np.where(begins, 4, 1))
    assert 0 < begins.sum() < len(begins)


def test_demonstrations_without_keyframes_are_refused(tmp_path: Path) -> None:
    features = {schema.STATE: {"dtype": "float32", "shape": (len(schema.SIM_STATE_NAMES),), "names": None}}
    plain = LeRobotDataset.create("local/plain", 10, features, root=tmp_path / "plain", use_videos=False)
    with pytest.raises(ValueError, match="annotate it"):
        convert(plain, tmp_path / "keysteps", "local/keysteps")
    assert not (tmp_path / "keysteps").exists()
