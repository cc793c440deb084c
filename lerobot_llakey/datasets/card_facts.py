"""What a dataset's card says, read from the dataset itself: labels, cameras, where the episodes came from."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
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


def read_facts(dataset: LeRobotDataset) -> CardFacts:
    """Read the columns that a card tells of; pictures are not decoded.

    Args:
        dataset: with an instruction column.
    """
    columns = _columns(dataset)
    episodes = columns["episode_index"]
    firsts = np.unique(episodes, return_index=True)[1]
    texts = [str(text) for text in columns[schema.INSTRUCTION]]
    segments = _segments(episodes, columns.get(schema.KEYFRAME_INDEX), texts)
    frames, counts = Counter(texts), Counter(text for chain in segments.values() for text in chain)
    lengths = [len(chain) for chain in segments.values()] or [0]
    seeds = columns.get(schema.EPISODE_SEED, np.full(len(episodes), -1))[firsts]
    return CardFacts(
        tasks=_counted(str(dataset.meta.tasks.index[task]) for task in columns["task_index"][firsts]),
        simulated_tasks=_counted(filter(None, _texts_at(columns, schema.EPISODE_TASK, firsts))),
        sequences=_counted(tuple(chain) for chain in segments.values()),
        instructions=[(text, counts[text], frames[text]) for text, _ in frames.most_common()],
        keyframes=(min(lengths), float(np.mean(lengths)), max(lengths)),
        events=_counted(_events(episodes, columns.get(schema.EPISODE_EVENT))),
        seeds=_seeds(seeds),
        cameras=[_camera(dataset.features, columns, name) for name in schema.cameras_of(dataset.features)],
        grammar=of_features(dataset.features, schema.INSTRUCTION),
        simulated=bool(len(seeds)) and bool((seeds >= 0).all()),
    )


def _columns(dataset: LeRobotDataset) -> dict[str, np.ndarray]:
    wanted = [
        *("episode_index", "task_index", schema.INSTRUCTION, schema.KEYFRAME_INDEX),
        *(schema.EPISODE_SEED, *schema.ORIGIN_COLUMNS),
        *(schema.extrinsics_key(name) for name in schema.cameras_of(dataset.features)),
    ]
    rows = dataset.hf_dataset.with_format("numpy")
    return {key: np.asarray(rows[key]) for key in wanted if key in dataset.features}


def _counted[Item](items: Any) -> list[tuple[Item, int]]:
    return Counter(items).most_common()


def _texts_at(columns: Mapping[str, np.ndarray], key: str, rows: np.ndarray) -> list[str]:
    return [str(text) for text in columns[key][rows]] if key in columns else []


def _segments(episodes: np.ndarray, indices: np.ndarray | None, texts: Sequence[str]) -> dict[int, list[str]]:
    """Each episode's instructions in their order; the same one again counts where another keyframe lies between."""
    chains: dict[int, list[str]] = defaultdict(list)
    last: dict[int, tuple[int, str]] = {}
    keys = np.zeros(len(texts), dtype=int) if indices is None else indices
    for episode, index, text in zip(episodes.tolist(), keys.reshape(-1).tolist(), texts, strict=True):
        if last.get(episode) != (index, text):
            chains[episode].append(text)
            last[episode] = (index, text)
    return dict(chains)


def _events(episodes: np.ndarray, events: np.ndarray | None) -> list[str]:
    if events is None:
        return []
    seen = {(int(episode), str(event)) for episode, event in zip(episodes, events, strict=True)}
    return [event for _, event in sorted(seen) if event]


def _seeds(seeds: np.ndarray) -> list[tuple[str, int, int, int]]:
    found = []
    for split, values in schema.SEED_RANGES.items():
        inside = [int(seed) for seed in seeds if int(seed) in values]
        if inside:
            found.append((split, min(inside), max(inside), len(inside)))
    return found


def _camera(features: Mapping[str, Any], columns: Mapping[str, np.ndarray], name: str) -> CameraFacts:
    height, width = features[schema.image_key(name)]["shape"][:2]
    poses = columns.get(schema.extrinsics_key(name))
    pose = "not known" if poses is None else "moves" if np.ptp(poses, axis=0).max() > 0 else "stands still"
    return CameraFacts(name, (int(height), int(width)), schema.depth_key(name) in features, pose)
