"""What a dataset's card says, read from the dataset itself: labels, cameras, where the episodes came from."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import EPISODE, TASKS, Columns, read_columns
from lerobot_llakey.checks.order import is_dense
from lerobot_llakey.grammar import Grammar, of_features


@dataclass(frozen=True)
class CameraFacts:
    """One camera.

    Attributes:
        name: as in its features' names.
        size: height and width in pixels.
        depth: whether there are depth maps.
        pose: "moves", "stands still", or "not known" where no calibration was recorded.
    """

    name: str
    size: schema.Size
    depth: bool
    pose: str


@dataclass(frozen=True)
class CardFacts:
    """What a dataset holds.

    Attributes:
        tasks: task as it was given in words, and number of episodes, the most frequent first.
        simulated_tasks: name of the simulator's task, and number of episodes.
        sequences: instructions of an episode in their order, and number of episodes.
        instructions: instruction, number of segments and number of frames.
        keyframes: fewest, mean and most keyframes an episode.
        events: unforeseen event, and number of episodes.
        seeds: split, first and last scene seed, and number of episodes.
        cameras: all of them.
        grammar: of the instructions.
        simulated: whether every episode has a scene seed; whatever has none was recorded.
        dense: whether every frame up to the last keyframe is there: demonstrations; keysteps leave frames out.
    """

    tasks: list[tuple[str, int]]
    simulated_tasks: list[tuple[str, int]]
    sequences: list[tuple[tuple[str, ...], int]]
    instructions: list[tuple[str, int, int]]
    keyframes: tuple[int, float, int]
    events: list[tuple[str, int]]
    seeds: list[tuple[str, int, int, int]]
    cameras: list[CameraFacts]
    grammar: Grammar
    simulated: bool
    dense: bool


def read_facts(dataset: LeRobotDataset) -> CardFacts:
    """Read the columns that a card tells of; pictures are not decoded.

    Args:
        dataset: with an instruction column.
    """
    columns = _columns(dataset)
    firsts = np.array([rows.start for rows in columns.episodes()], dtype=int)
    texts = [str(text) for text in columns[schema.INSTRUCTION]]
    indices = columns[schema.KEYFRAME_INDEX] if schema.KEYFRAME_INDEX in columns else np.zeros(len(texts), dtype=int)
    segments = [_segments(indices[rows], texts[rows]) for rows in columns.episodes()]
    frames, counts = Counter(texts), Counter(text for chain in segments for text in chain)
    lengths = [len(chain) for chain in segments] or [0]
    seeds = columns[schema.EPISODE_SEED][firsts] if schema.EPISODE_SEED in columns else np.full(len(firsts), -1)
    return CardFacts(
        tasks=_counted(str(dataset.meta.tasks.index[task]) for task in columns[TASKS][firsts]),
        simulated_tasks=_counted(filter(None, _texts_at(columns, schema.EPISODE_TASK, firsts))),
        sequences=_counted(segments),
        instructions=[(text, counts[text], frames[text]) for text, _ in frames.most_common()],
        keyframes=(min(lengths), float(np.mean(lengths)), max(lengths)),
        events=_counted(_events(columns)),
        seeds=_seeds(seeds),
        cameras=[_camera(dataset.features, columns, name) for name in schema.cameras_of(dataset.features)],
        grammar=of_features(dataset.features, schema.INSTRUCTION),
        simulated=bool(len(seeds)) and bool((seeds >= 0).all()),
        dense=is_dense(columns),
    )


def _columns(dataset: LeRobotDataset) -> Columns:
    """All rows of the columns that a card tells of."""
    wanted = [
        *(EPISODE, TASKS, schema.INSTRUCTION, schema.KEYFRAME_INDEX, schema.NEXT_KEYFRAME),
        *(schema.EPISODE_SEED, *schema.ORIGIN_COLUMNS),
        *(schema.extrinsics_key(name) for name in schema.cameras_of(dataset.features)),
    ]
    features = {key: dataset.features[key] for key in wanted if key in dataset.features}
    files = list(read_columns(Path(dataset.root), features, most=sys.maxsize))
    return Columns({key: np.concatenate([file[key] for file in files]) for key in features if files}, {})


def _counted[Item](items: Any) -> list[tuple[Item, int]]:
    return Counter(items).most_common()


def _texts_at(columns: Columns, key: str, rows: np.ndarray) -> list[str]:
    return [str(text) for text in columns[key][rows]] if key in columns else []


def _segments(indices: np.ndarray, texts: Sequence[str]) -> tuple[str, ...]:
    """An episode's instructions in their order; the same one again counts where another keyframe lies between."""
    return tuple(text for (_, text), _ in groupby(zip(indices.tolist(), texts, strict=True)))


def _events(columns: Columns) -> list[str]:
    if schema.EPISODE_EVENT not in columns:
        return []
    events = columns[schema.EPISODE_EVENT]
    return [event for rows in columns.episodes() for event in sorted(set(map(str, events[rows]))) if event]


def _seeds(seeds: np.ndarray) -> list[tuple[str, int, int, int]]:
    found = []
    for split, values in schema.SEED_RANGES.items():
        inside = [int(seed) for seed in seeds if int(seed) in values]
        if inside:
            found.append((split, min(inside), max(inside), len(inside)))
    return found


def _camera(features: Mapping[str, Any], columns: Columns, name: str) -> CameraFacts:
    height, width = features[schema.image_key(name)]["shape"][:2]
    key, pose = schema.extrinsics_key(name), "not known"
    if key in columns:
        pose = "moves" if np.ptp(columns[key], axis=0).max() > 0 else "stands still"
    return CameraFacts(name, (int(height), int(width)), schema.depth_key(name) in features, pose)
