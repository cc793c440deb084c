"""Which frames of a demonstration become training samples (paper, sections III-B and III-C)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.utils.constants import DEFAULT_FEATURES
from tqdm import tqdm

from lerobot_llakey import schema
from lerobot_llakey.datasets.image_dataset import ImageDatasetWriter

SamplingMode = Literal["thin", "repeat"]

STRIDE = 10
MIN_PER_SEGMENT = 3
KEYFRAME_REPEATS = 6


def sampling_mode(name: str) -> SamplingMode:
    """The sampling mode of a name.

    Raises:
        ValueError: if there is none.
    """
    if name == "thin":
        return "thin"
    if name == "repeat":
        return "repeat"
    raise ValueError(f"Expected a mode of keysteps out of thin and repeat, got {name!r}; pick one of these.")


def select(
    keyframes: Sequence[int],
    length: int,
    *,
    rng: np.random.Generator,
    stride: int = STRIDE,
    min_per_segment: int = MIN_PER_SEGMENT,
    keyframe_repeats: int = KEYFRAME_REPEATS,
    mode: SamplingMode = "thin",
) -> list[int]:
    """The frames of an episode to train on, in order.

    A segment starts at frame 0 or at a keyframe and ends before the next keyframe, which is what its samples lead to.
    Its first frame is the *keyframe sample*: seen from there, the next instruction has just changed. All other samples
    are in-between samples. The paper takes every tenth frame, tops each segment up to three samples at random, and
    counts the keyframe samples six times. The last frame leads nowhere and is never taken.

    Args:
        keyframes: increasing frame indices above 0 that end at ``length - 1``.
        length: number of frames of the episode.
        rng: draws the samples that top up, and in mode "thin" those that stay.
        stride: take every ``stride``-th frame.
        min_per_segment: samples a segment, its keyframe sample included; fewer only where it has fewer frames.
        keyframe_repeats: how often a keyframe sample counts.
        mode: "repeat" stores keyframe samples that often; "thin" keeps the same proportions without duplicates: each
            keyframe sample once, each in-between sample with probability ``1 / keyframe_repeats``.

    Raises:
        ValueError: if the keyframes do not fit the length or a number is below 1.
    """
    starts = [0, *keyframes]
    if len(starts) < 2 or starts[-1] != length - 1 or any(a >= b for a, b in pairwise(starts)):
        raise ValueError(
            f"Expected increasing keyframes above 0 that end at the last frame {length - 1}, got {list(keyframes)}; "
            "use those of the same episode."
        )
    if min(stride, min_per_segment, keyframe_repeats) < 1:
        raise ValueError(
            f"Expected stride, min_per_segment and keyframe_repeats of 1 or more, got {stride}, {min_per_segment} and "
            f"{keyframe_repeats}; correct the one that is not."
        )
    chosen: list[int] = []
    for first, stop in pairwise(starts):
        between = [frame for frame in range(first + 1, stop) if frame % stride == 0]
        others = [frame for frame in range(first + 1, stop) if frame % stride]
        missing = min(max(0, min_per_segment - 1 - len(between)), len(others))
        between += rng.choice(others, missing, replace=False).tolist() if missing else []
        if sampling_mode(mode) == "thin":
            chosen += [first, *sorted(frame for frame in between if rng.random() * keyframe_repeats < 1)]
        else:
            chosen += [first] * keyframe_repeats + sorted(between)
    return chosen


def convert(source: LeRobotDataset, root: Path, repo_id: str, *, mode: SamplingMode = "thin", seed: int = 0) -> int:
    """Write the keysteps of a demonstrations dataset, simulated or real, as a dataset of their own.

    Args:
        source: demonstrations with the contract's keyframe and instruction columns; any cameras.
        root: folder of the keysteps, which must not exist yet.
        repo_id: their name.
        mode: see :func:`select`.
        seed: of the random choices.

    Returns:
        Number of keysteps.

    Raises:
        ValueError: if a column is missing.
        FileExistsError: if the folder exists.
    """
    missing = [key for key in (schema.NEXT_KEYFRAME, schema.INSTRUCTION, schema.ACTION) if key not in source.features]
    if missing:
        raise ValueError(
            f"Expected demonstrations with keyframes and instructions, got {source.repo_id} without "
            f"{', '.join(missing)}; annotate it with llakey annotate."
        )
    features = {
        key: {**feature, "dtype": "image" if feature["dtype"] == "video" else feature["dtype"], "info": _info(feature)}
        for key, feature in source.features.items()
        if key not in DEFAULT_FEATURES and feature["dtype"] != "language"
    }
    columns = source.hf_dataset.with_format("numpy")
    next_frames, episodes = np.array(columns[schema.NEXT_KEYFRAME]), np.array(columns["episode_index"])
    rng = np.random.default_rng(seed)
    count = 0
    with ImageDatasetWriter(repo_id, root, source.fps, features, source.meta.robot_type) as writer:
        for episode in tqdm(np.unique(episodes), desc="keysteps", unit="episode"):
            rows = np.flatnonzero(episodes == episode)
            chosen = select(sorted(set(next_frames[rows].tolist())), len(rows), rng=rng, mode=mode)
            frames = {frame: _frame(source[int(rows[frame])], features) for frame in sorted(set(chosen))}
            writer.add_episode([frames[frame] for frame in chosen])
            count += len(chosen)
    return count


def _info(feature: Mapping[str, Any]) -> dict[str, Any] | None:
    """What remains true of a video's notes once it is pictures."""
    is_depth = (feature.get("info") or {}).get("is_depth_map", False)
    return {"is_depth_map": True} if is_depth else None


def _frame(item: Mapping[str, Any], features: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """A loaded item, as it has to be written again."""
    frame: dict[str, Any] = {schema.TASK: item[schema.TASK]}
    for key, feature in features.items():
        value = item[key]
        if feature["dtype"] == "image":
            pixels = value.permute(1, 2, 0).numpy()
            is_depth = pixels.shape[-1] == 1
            frame[key] = np.rint(pixels if is_depth else pixels * 255).astype(np.uint16 if is_depth else np.uint8)
        elif feature["dtype"] == "string":
            frame[key] = value
        else:
            frame[key] = np.asarray(value, dtype=feature["dtype"]).reshape(feature["shape"])
    return frame
