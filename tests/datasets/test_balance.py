"""The selection rule of the training samples."""

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lerobot_llakey import schema
from lerobot_llakey.datasets.balance import PAPER, Balance, sampling_mode


@st.composite
def keyframes_of_an_episode(draw: st.DrawFn) -> list[int]:
    gaps = draw(st.lists(st.integers(1, 40), min_size=1, max_size=6))
    return np.cumsum(gaps).tolist()


def generator() -> np.random.Generator:
    return np.random.default_rng(0)


@given(keyframes_of_an_episode(), st.integers(2, 12), st.integers(1, 5), st.integers(1, 8))
def test_repeat_is_the_papers_sampling(keyframes: list[int], stride: int, least: int, repeats: int) -> None:
    length = keyframes[-1] + 1
    chosen = Counter(Balance("repeat", stride, least, repeats).select(keyframes, length, generator()))
    assert length - 1 not in chosen
    for first, stop in pairwise([0, *keyframes]):
        inside = [frame for frame in chosen if first < frame < stop]
        assert chosen[first] == repeats
        assert all(chosen[frame] == 1 for frame in inside)
        assert {frame for frame in range(first + 1, stop) if frame % stride == 0} <= set(inside)
        assert len(inside) >= min(least - 1, stop - first - 1)


def test_the_papers_numbers_are_the_default() -> None:
    assert (PAPER.stride, PAPER.min_per_segment, PAPER.keyframe_repeats) == (10, 3, 6)


@given(keyframes_of_an_episode())
def test_thin_takes_every_keyframe_sample_once_and_nothing_twice(keyframes: list[int]) -> None:
    chosen = PAPER.select(keyframes, keyframes[-1] + 1, generator())
    assert chosen == sorted(set(chosen))
    assert {0, *keyframes[:-1]} <= set(chosen)
    assert keyframes[-1] not in chosen


@pytest.mark.parametrize("repeats", [1, 3, 6])
def test_thin_and_weight_keep_the_proportions_of_repeat(repeats: int) -> None:
    keyframes, rng = [30, 45, 120], generator()
    starts = {0, 30, 45}

    def between_to_keyframe(mode: str) -> float:
        balance = Balance(sampling_mode(mode), keyframe_repeats=repeats)
        chosen = [frame for _ in range(600) for frame in balance.select(keyframes, 121, rng)]
        weights = [float(balance.columns(frame, keyframes).get(schema.SAMPLE_WEIGHT, [1])[0]) for frame in chosen]
        at_keyframes = sum(weight for frame, weight in zip(chosen, weights, strict=True) if frame in starts)
        return (sum(weights) - at_keyframes) / at_keyframes

    assert between_to_keyframe("thin") == pytest.approx(between_to_keyframe("repeat"), rel=0.1)
    assert between_to_keyframe("weight") == pytest.approx(between_to_keyframe("repeat"))


def test_only_weighing_adds_a_column() -> None:
    assert PAPER.features() == {} and PAPER.columns(0, [9]) == {}
    weighing = Balance("weight", keyframe_repeats=4)
    assert list(weighing.features()) == [schema.SAMPLE_WEIGHT] == list(weighing.columns(3, [9]))
    assert [float(weighing.columns(frame, [9, 20])[schema.SAMPLE_WEIGHT][0]) for frame in (0, 3, 9)] == [4, 1, 4]


def test_the_generator_decides() -> None:
    samples = [PAPER.select([40, 90], 91, np.random.default_rng(seed)) for seed in (1, 1, 2)]
    assert samples[0] == samples[1] != samples[2]


@pytest.mark.parametrize("keyframes", [[], [3, 3, 9], [0, 9], [5, 8]])
def test_keyframes_of_another_episode_are_refused(keyframes: list[int]) -> None:
    with pytest.raises(ValueError, match="end at the last frame 9"):
        PAPER.select(keyframes, 10, generator())


def test_bad_settings_are_refused() -> None:
    with pytest.raises(ValueError, match="stride"):
        Balance(stride=0)
    with pytest.raises(ValueError, match="thin, repeat and weight"):
        sampling_mode("fat")
