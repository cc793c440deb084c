"""Which samples of a dataset are asked about, and which task each belongs to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets.balance import Balance
from lerobot_llakey.datasets.collect_record import RECORD, read_record
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.hand import hand_columns, names_of

_ONCE = Balance(keyframe_repeats=1)
"""The paper's samples, each counted once."""
_NEEDED = (schema.IS_KEYFRAME, schema.INSTRUCTION)


def check_columns(dataset: LeRobotDataset) -> None:
    """Refuse a dataset without instructions or that does not tell keyframes apart.

    Raises:
        LlakeyError: naming what is missing.
    """
    missing = [key for key in _NEEDED if key not in dataset.features]
    if missing:
        raise LlakeyError(
            f"Expected the columns {missing} in the dataset {dataset.repo_id}, got none; make one with `llakey "
            "keysteps` from demonstrations, or give your own recordings instructions with `llakey annotate`."
        )


def samples(dataset: LeRobotDataset, max_samples: int | None = None, seed: int = 0) -> list[int]:
    """Positions of the samples to ask about.

    All of a keysteps dataset. Of demonstrations, which hold every frame, those that the paper's rule draws (every tenth
    frame, three a segment), each once; an episode's last frame leads nowhere and is left out.

    Args:
        dataset: keysteps or demonstrations.
        max_samples: at most so many, spread evenly over the dataset; None for all.
        seed: of the frames that top up short segments of demonstrations.

    Raises:
        LlakeyError: if the number is below 1.
    """
    if max_samples is not None and max_samples < 1:
        raise LlakeyError(f"Expected max_samples of 1 or more, got {max_samples}; leave it out for all.")
    episodes = _column(dataset, "episode_index")
    chosen: list[int] = []
    rng = np.random.default_rng(seed)
    ends = _column(dataset, schema.NEXT_KEYFRAME) if schema.NEXT_KEYFRAME in dataset.features else None
    for episode in np.unique(episodes):
        rows = np.flatnonzero(episodes == episode)
        keyframes = [] if ends is None else sorted(set(ends[rows].tolist()))
        if keyframes and keyframes[-1] == len(rows) - 1:
            chosen += rows[_ONCE.select(keyframes, len(rows), rng)].tolist()
        else:
            chosen += rows.tolist()
    if max_samples is None or max_samples >= len(chosen):
        return chosen
    return [chosen[index] for index in np.linspace(0, len(chosen) - 1, max_samples).astype(int)]


def task_names(dataset: LeRobotDataset) -> list[str]:
    """The task of each sample.

    From the column ``episode.task``; in datasets without it from the record of a collection, whose tasks take turns;
    else, for anybody's own recordings, the skill instruction itself.
    """
    skills = [str(name) for name in dataset.meta.tasks.sort_values("task_index").index]
    texts = [skills[int(index)] for index in _column(dataset, "task_index")]
    if schema.EPISODE_TASK in dataset.features:
        named = [str(name) for name in dataset.hf_dataset.with_format(None)[schema.EPISODE_TASK]]
        return [name or text for name, text in zip(named, texts, strict=True)]
    if (dataset.root / RECORD).exists():
        record: dict[str, Any] = read_record(dataset.root)
        tasks = record["settings"].get("tasks")
        if tasks and record["episodes"] == dataset.meta.total_episodes:
            return [tasks[int(episode) % len(tasks)] for episode in _column(dataset, "episode_index")]
    return texts


def hand_places(features: Mapping[str, Any]) -> tuple[int, ...]:
    """Where the hand stands in the state of a dataset with these features; nothing where it has no state."""
    return hand_columns(names_of(features[schema.STATE])) if schema.STATE in features else ()


def joint_places(features: Mapping[str, Any]) -> list[int]:
    """Where the joints stand among the velocities of a dataset with these features."""
    names = names_of(features[schema.VELOCITY]) if schema.VELOCITY in features else []
    return [place for place, name in enumerate(names) if name != schema.GRIPPER_VELOCITY]


def _column(dataset: LeRobotDataset, key: str) -> np.ndarray:
    return np.asarray(dataset.hf_dataset.with_format("numpy")[key]).reshape(-1)
