"""The selection rule of the training samples, and keysteps drawn from demonstrations."""

from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets.keysteps import KEYFRAME_REPEATS, convert, select
from lerobot_llakey.datasets.plan import Targets


@st.composite
def keyframes_of_an_episode(draw: st.DrawFn) -> list[int]:
    gaps = draw(st.lists(st.integers(1, 40), min_size=1, max_size=6))
    return np.cumsum(gaps).tolist()


def generator() -> np.random.Generator:
    return np.random.default_rng(0)


@given(keyframes_of_an_episode())
def test_repeat_is_the_papers_sampling(keyframes: list[int]) -> None:
    length = keyframes[-1] + 1
    chosen = Counter(select(keyframes, length, rng=generator(), mode="repeat"))
    assert length - 1 not in chosen
    for first, stop in pairwise([0, *keyframes]):
        inside = [frame for frame in chosen if first < frame < stop]
        assert chosen[first] == KEYFRAME_REPEATS
        assert all(chosen[frame] == 1 for frame in inside)
        assert {frame for frame in range(first + 1, stop) if frame % 10 == 0} <= set(inside)
        assert len(inside) >= min(2, stop - first - 1)


@given(keyframes_of_an_episode())
def test_thin_takes_every_keyframe_sample_once_and_nothing_twice(keyframes: list[int]) -> None:
    chosen = select(keyframes, keyframes[-1] + 1, rng=generator())
    assert chosen == sorted(set(chosen))
    assert {0, *keyframes[:-1]} <= set(chosen)
    assert keyframes[-1] not in chosen


def test_thin_keeps_the_proportions_of_repeat() -> None:
    keyframes, rng = [30, 45, 120], generator()
    starts = {0, 30, 45}

    def between_to_keyframe(mode: str) -> float:
        chosen = [frame for _ in range(600) for frame in select(keyframes, 121, rng=rng, mode=mode)]  # type: ignore[arg-type]
        at_keyframes = sum(frame in starts for frame in chosen)
        return (len(chosen) - at_keyframes) / at_keyframes

    assert between_to_keyframe("thin") == pytest.approx(between_to_keyframe("repeat"), rel=0.1)


def test_the_generator_decides() -> None:
    samples = [select([40, 90], 91, rng=np.random.default_rng(seed)) for seed in (1, 1, 2)]
    assert samples[0] == samples[1] != samples[2]


@pytest.mark.parametrize("keyframes", [[], [3, 3, 9], [0, 9], [5, 8]])
def test_keyframes_of_another_episode_are_refused(keyframes: list[int]) -> None:
    with pytest.raises(ValueError, match="end at the last frame 9"):
        select(keyframes, 10, rng=generator())


def test_bad_settings_are_refused() -> None:
    with pytest.raises(ValueError, match="stride"):
        select([9], 10, rng=generator(), stride=0)
    with pytest.raises(ValueError, match="thin and repeat"):
        select([9], 10, rng=generator(), mode="fat")  # type: ignore[arg-type]


def test_keysteps_of_demonstrations_are_their_frames(collected: Targets, tmp_path: Path) -> None:
    source = LeRobotDataset("local/demonstrations", root=collected.demonstrations)
    count = convert(source, tmp_path / "keysteps", "local/keysteps", seed=1)
    keysteps = LeRobotDataset("local/keysteps", root=tmp_path / "keysteps")
    assert len(keysteps) == count < len(source)
    assert keysteps.num_episodes == source.num_episodes
    shown = set(schema.keystep_features())
    assert shown <= set(keysteps.features)
    # The first sample of each episode is its first frame.
    for episode in range(source.num_episodes):
        sample = keysteps[int(keysteps.meta.episodes[episode]["dataset_from_index"])]
        frame = source[int(source.meta.episodes[episode]["dataset_from_index"])]
        for key in (schema.STATE, schema.ACTION, schema.INTRINSICS, schema.EXTRINSICS, schema.EPISODE_SEED):
            np.testing.assert_array_equal(sample[key], frame[key])
        for key in (schema.INSTRUCTION, schema.PREVIOUS_INSTRUCTION, schema.TASK):
            assert sample[key] == frame[key]
        np.testing.assert_allclose(sample[schema.image_key("front")], frame[schema.image_key("front")], atol=1e-6)
        np.testing.assert_array_equal(sample[schema.depth_key("wrist")], frame[schema.depth_key("wrist")])


def test_demonstrations_without_keyframes_are_refused(tmp_path: Path) -> None:
    features = {schema.STATE: {"dtype": "float32", "shape": (schema.STATE_DIM,), "names": None}}
    plain = LeRobotDataset.create("local/plain", 10, features, root=tmp_path / "plain", use_videos=False)
    with pytest.raises(ValueError, match="annotate it"):
        convert(plain, tmp_path / "keysteps", "local/keysteps")
    assert not (tmp_path / "keysteps").exists()
