"""Collecting: the datasets' content, and runs that are stopped, resumed or extended."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets import collect as module
from lerobot_llakey.datasets.collect import collect
from lerobot_llakey.datasets.demonstrations import sim_features
from lerobot_llakey.datasets.plan import CollectSettings, Targets
from lerobot_llakey.geometry import DOWN
from lerobot_llakey.instructions import parse


def table(root: Path | None) -> pd.DataFrame:
    """All rows of a dataset, without pictures and cameras."""
    dataset = LeRobotDataset("local/any", root=root)
    kept = [key for key, feature in dataset.features.items() if len(feature["shape"]) == 1]
    return dataset.hf_dataset.select_columns(kept).with_format("pandas")[:]


def test_quaternions_never_jump_and_actions_have_the_sign_of_the_state_they_reach(
    demonstrations: LeRobotDataset,
) -> None:
    rows = demonstrations.hf_dataset.with_format("numpy")
    episodes, next_frames = np.array(rows["episode_index"]), np.array(rows[schema.NEXT_KEYFRAME])
    columns = (schema.STATE, *map(schema.extrinsics_key, schema.CAMERAS))
    for episode in range(demonstrations.num_episodes):
        of = episodes == episode
        for key in columns:
            quaternions = np.array(rows[key])[of][:, schema.QUATERNION]
            assert (np.sum(quaternions[1:] * quaternions[:-1], axis=1) > 0).all(), key
        states, actions = np.array(rows[schema.STATE])[of], np.array(rows[schema.ACTION])[of]
        assert states[0, schema.QUATERNION] @ DOWN >= 0
        np.testing.assert_allclose(
            actions[:, schema.QUATERNION], states[next_frames[of]][:, schema.QUATERNION], atol=1e-6
        )


def seeds(root: Path | None) -> list[int]:
    """The scene seed of each episode, in order."""
    return table(root).groupby("episode_index")[schema.EPISODE_SEED].first().tolist()


@pytest.fixture(scope="module")
def demonstrations(collected: Targets) -> LeRobotDataset:
    return LeRobotDataset("local/demonstrations", root=collected.demonstrations)


def test_demonstrations_have_every_column_of_the_contract(demonstrations: LeRobotDataset) -> None:
    expected = sim_features(32, "video")
    assert set(expected) <= set(demonstrations.features)
    item = demonstrations[0]
    for camera in schema.CAMERAS:
        assert item[schema.image_key(camera)].shape == (3, 32, 32)
        assert item[schema.depth_key(camera)].shape == (1, 32, 32)
        assert item[schema.depth_key(camera)].max() > 100
        assert item[schema.intrinsics_key(camera)].shape == (4,) and item[schema.extrinsics_key(camera)].shape == (7,)
    assert item[schema.PREVIOUS_INSTRUCTION] == ""
    parse(item[schema.INSTRUCTION])


@pytest.mark.parametrize("camera", schema.CAMERAS)
def test_depth_is_the_same_in_videos_and_keysteps(
    camera: str, demonstrations: LeRobotDataset, collected: Targets
) -> None:
    keysteps = LeRobotDataset("local/keysteps", root=collected.keysteps)
    key = schema.depth_key(camera)
    exact, stored = keysteps[0][key], demonstrations[0][key]
    within = exact <= 1000 * schema.DEPTH_RANGE_METRES[1]
    assert within.float().mean() > 0.3
    assert (exact - stored)[within].abs().max() < 1e-2


def test_variations_take_turns_and_keyframe_columns_agree(demonstrations: LeRobotDataset) -> None:
    rows = table(demonstrations.root)
    assert rows.groupby("episode_index")[schema.EPISODE_VARIATION].first().tolist() == [0, 1, 2]
    for _, episode in rows.groupby("episode_index"):
        keyframes = episode.loc[episode[schema.IS_KEYFRAME], "frame_index"]
        assert sorted(set(episode[schema.NEXT_KEYFRAME])) == keyframes.tolist()
        assert keyframes.iloc[-1] == len(episode) - 1
        assert episode[schema.INSTRUCTION].nunique() == len(keyframes)


def test_keysteps_never_hold_the_last_frame_and_begin_each_episode(collected: Targets) -> None:
    rows = table(collected.keysteps)
    assert rows.groupby("episode_index").size().min() >= 3
    firsts = rows[rows["frame_index"] == 0]
    assert (firsts[schema.PREVIOUS_INSTRUCTION] == "").all() and (firsts[schema.KEYFRAME_INDEX] == 0).all()
    changed = rows[rows[schema.IS_KEYFRAME]]
    assert (changed[schema.PREVIOUS_INSTRUCTION] != changed[schema.INSTRUCTION]).all()


def test_a_finished_collection_is_left_alone(collected: Targets, settings: CollectSettings) -> None:
    before = seeds(collected.keysteps)
    calls: list[tuple[int, int]] = []
    collect(settings, collected, num_workers=1, progress=lambda *call: calls.append(call))
    assert calls == [] and seeds(collected.keysteps) == before


@pytest.fixture
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "part_size", lambda episodes, workers: 1)


def test_a_stopped_run_goes_on_without_losing_or_doubling(
    collected: Targets, settings: CollectSettings, targets: Targets, small_parts: None
) -> None:
    kept: list[int] = []

    def stop(*_: int) -> None:
        kept.append(1)
        if len(kept) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        collect(settings, targets, num_workers=1, progress=stop)
    assert targets.keysteps is not None and not targets.keysteps.exists()
    again: list[int] = []
    collect(settings, targets, num_workers=1, progress=lambda *_: again.append(1))
    assert len(again) == 2  # the episode that was being written is written anew, the first one is not
    pd.testing.assert_frame_equal(table(targets.keysteps), table(collected.keysteps))
    assert [path.name for path in targets.keysteps.parent.iterdir()] == ["keysteps"]


def test_a_run_stopped_while_merging_loses_nothing(
    collected: Targets, settings: CollectSettings, targets: Targets, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("lerobot_llakey.datasets.parts.merge_into", interrupted)
        with pytest.raises(KeyboardInterrupt):
            collect(settings, targets, num_workers=1, progress=lambda *_: None)
    again: list[int] = []
    collect(settings, targets, num_workers=1, progress=lambda *_: again.append(1))
    assert again == []
    assert seeds(targets.keysteps) == seeds(collected.keysteps)


def test_a_collection_is_extended_by_asking_for_more(
    collected: Targets, settings: CollectSettings, targets: Targets
) -> None:
    collect(replace(settings, num_episodes=1), targets, num_workers=1, progress=lambda *_: None)
    collect(settings, targets, num_workers=1, progress=lambda *_: None)
    pd.testing.assert_frame_equal(table(targets.keysteps), table(collected.keysteps))
