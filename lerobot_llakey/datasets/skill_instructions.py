"""Instructions of recordings that need nobody to type them: out of a skill's file, or as another tool wrote them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from lerobot.datasets.language import LANGUAGE_PERSISTENT
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.datasets.sequences import TaskInstructions, shown
from lerobot_llakey.errors import LlakeyError

SUBTASK = "subtask"
"""LeRobot's style of rows that name what is done from their time on, and what ``--instructions`` says for them."""
_SHOWN = 3
"""Episodes that an error names."""


def from_sequences(found: Sequence[FoundKeyframes], tasks: Mapping[str, TaskInstructions]) -> dict[int, list[str]]:
    """Instructions by episode out of sequences; a sequence fits by its number of keyframes and the gripper.

    Without a gripper, and with free text, the number alone decides.

    Args:
        found: episodes with their keyframes.
        tasks: as :func:`lerobot_llakey.datasets.sequences.read_sequences` gives them.

    Raises:
        LlakeyError: if no task describes an episode's skill, or no sequence fits it.
    """
    spoken: dict[int, list[str]] = {}
    misfits: list[str] = []
    for episode in found:
        fitting = [task for task in tasks.values() if task.describes(episode.task)]
        if not fitting:
            forms = [task.descriptions[0] for task in tasks.values()]
            raise LlakeyError(
                f"Expected a skill out of the descriptions ({'; '.join(map(repr, forms))}, ...), got {episode.task!r} "
                f"in episode {episode.episode}; add it to the file for --instructions."
            )
        opened, first = episode.opened[episode.keyframes].tolist(), bool(episode.opened[0])
        gripper = schema.HAND_NAMES[7] in episode.names
        fits = (task.fitting([episode.task], opened, open_at_first=first, by_count=not gripper) for task in fitting)
        if (fit := next((one for one in fits if one is not None), None)) is not None:
            spoken[episode.episode] = fit[1]
            continue
        wanted = " or ".join(task.patterns(first) for task in fitting)
        misfits.append(f"{shown(opened)} in episode {episode.episode} ({fitting[0].task}: {wanted})")
    if misfits:
        raise LlakeyError(
            f"Expected keyframes whose number and gripper (o open, c closed) fit a sequence of instructions, got "
            f"{len(misfits)} of {len(found)} episodes that do not: {'; '.join(misfits[:_SHOWN])}; add sequences, "
            "correct keyframes by --template, or choose others by --keyframes."
        )
    return spoken


def from_subtasks(source: LeRobotDataset, found: Sequence[FoundKeyframes]) -> dict[int, list[str]]:
    """Instructions by episode out of LeRobot's rows of style ``subtask``, as ``lerobot-annotate`` writes them.

    Every frame of an episode holds all its rows; each names what is done from its ``timestamp`` until the next one's.
    A segment's instruction is the one that lasts longest within it.

    Args:
        source: the recordings.
        found: their keyframes.

    Raises:
        LlakeyError: if the dataset has no such rows, or an episode has none.
    """
    if LANGUAGE_PERSISTENT not in source.features:
        raise LlakeyError(
            f"Expected the column {LANGUAGE_PERSISTENT} with rows of style {SUBTASK} in {source.repo_id}, got none; "
            "write them with lerobot-annotate, or give a file with --instructions."
        )
    episodes = np.asarray(source.hf_dataset.with_format("numpy")["episode_index"])
    first = [int(np.flatnonzero(episodes == episode.episode)[0]) for episode in found]
    column = source.hf_dataset.with_format(None).select_columns([LANGUAGE_PERSISTENT]).select(first)
    spoken = {}
    for episode, rows in zip(found, column[LANGUAGE_PERSISTENT], strict=True):
        said = {float(row["timestamp"]): str(row["content"] or "").strip() for row in rows if row["style"] == SUBTASK}
        times = sorted(time for time, text in said.items() if text)
        if not times:
            raise LlakeyError(
                f"Expected rows of style {SUBTASK} in {LANGUAGE_PERSISTENT} of episode {episode.episode}, got none; "
                "write them with lerobot-annotate, or give a file with --instructions."
            )
        begins, ends = np.array([-np.inf, *times[1:]]), np.array([*times[1:], np.inf])
        texts = []
        for segment in range(len(episode.keyframes)):
            begin, end = episode.seconds(segment)
            lasts = np.minimum(ends, end) - np.maximum(begins, begin)
            texts.append(said[times[int(lasts.argmax())]])
        spoken[episode.episode] = texts
    return spoken
