"""Keyframes and instructions for a person's own recordings.

Keyframes are discovered from the robot's states; what a person adds is one instruction a segment, in a CSV file with
the columns ``episode,segment,instruction``, in a JSON file ``{"0": ["grasp the cup", ...], ...}``, or typed.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
from lerobot.datasets.compute_stats import get_feature_stats
from lerobot.datasets.io_utils import load_stats, write_stats
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.datasets.language import write_language
from lerobot_llakey.datasets.rewrite import rewrite
from lerobot_llakey.datasets.units import check_names, check_states
from lerobot_llakey.datasets.velocities import estimate_velocities
from lerobot_llakey.datasets.wording import by_place, refuse_outside_grammar
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import check_writable
from lerobot_llakey.folders import new_folder, refuse_occupied
from lerobot_llakey.grammar import INFO_KEY, Grammar
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.keyframes import discover_keyframes
from lerobot_llakey.labels import Labels, label


def find_keyframes(source: LeRobotDataset, **settings: float) -> list[FoundKeyframes]:
    """Discover every episode's keyframes.

    Args:
        source: a dataset whose state has the contract's columns.
        settings: of :func:`lerobot_llakey.keyframes.discover_keyframes`.

    Raises:
        LlakeyError: if the dataset has no such state, it is in other units or another order, an episode is too short,
            or only some of the episodes are loaded.
    """
    shape = tuple(source.features.get(schema.STATE, {}).get("shape", ()))
    if shape != (schema.STATE_DIM,):
        raise LlakeyError(
            f"Expected {schema.STATE} of {schema.STATE_DIM} numbers ({', '.join(schema.STATE_NAMES)}) in "
            f"{source.repo_id}, got {f'shape {shape}' if shape else 'no such column'}; record these."
        )
    check_names(source.features[schema.STATE])
    if len(source.hf_dataset) != source.meta.total_frames:
        raise LlakeyError(
            f"Expected all {source.meta.total_episodes} episodes of {source.repo_id}, got {source.num_episodes}; load "
            "it without a choice of episodes."
        )
    rows = source.hf_dataset.select_columns([schema.STATE, "episode_index", "task_index"]).with_format("numpy")[:]
    states = np.asarray(rows[schema.STATE], dtype=np.float32)
    check_states(states, rows["episode_index"])
    found = []
    for episode in np.unique(rows["episode_index"]):
        frames = np.flatnonzero(rows["episode_index"] == episode)
        part = states[frames]
        if len(part) < 2:
            raise LlakeyError(
                f"Expected episodes of two frames or more in {source.repo_id}, got one frame in episode {episode}; "
                "remove it with lerobot-edit-dataset."
            )
        keyframes = discover_keyframes(part[:, schema.JOINTS], part[:, schema.GRIPPER], source.fps, **settings)
        task = str(source.meta.tasks.iloc[int(rows["task_index"][frames[0]])].name)
        found.append(FoundKeyframes(int(episode), task, part, keyframes, source.fps))
    return found


def annotate(
    source: LeRobotDataset,
    found: Sequence[FoundKeyframes],
    instructions: Mapping[int, Sequence[str]],
    root: Path,
    repo_id: str,
    *,
    ignore_collision: bool = True,
    grammar: Grammar = BASIC_GRAMMAR,
) -> LeRobotDataset:
    """Write a copy of a dataset with the contract's keyframe and instruction columns.

    The copy appears whole or not at all. Where the source has no velocities, the copy's are estimated from its states.

    The copy's action is the next keyframe's; the action that was recorded stays in the source alone.

    Args:
        source: the recordings, left as they are.
        found: their keyframes.
        instructions: by episode, one a segment.
        root: folder of the copy, which must not exist yet.
        repo_id: its name.
        ignore_collision: whether the planner may touch things on the way to a keyframe: recordings do not tell.
        grammar: of the instructions; the copy keeps it.

    Raises:
        LlakeyError: if an episode's instructions are missing, not as many as its segments, or outside the grammar, or
            the folder cannot be written to.
        FileInTheWayError: if the folder exists.
    """
    refuse_occupied(root)
    spoken = {episode.episode: instructions.get(episode.episode, ()) for episode in found}
    refuse_outside_grammar(by_place(spoken), grammar=grammar)
    labels = [_label(episode, instructions.get(episode.episode, ()), ignore_collision) for episode in found]
    kept = (schema.EPISODE_SEED, schema.EPISODE_VARIATION, schema.EPISODE_SEQUENCE, *schema.LATER_COLUMNS)
    columns = {
        key: values for key, values in _columns(found, labels).items() if not (key in kept and key in source.features)
    }
    check_writable(root, sum(file.stat().st_size for file in source.root.rglob("*") if file.is_file()))
    with new_folder(root) as folder:
        shutil.copytree(source.root, folder, ignore=shutil.ignore_patterns("README.md", ".cache"))
        _relabel(folder, columns, grammar)
    return LeRobotDataset(repo_id, root=root)


def _relabel(root: Path, columns: Mapping[str, np.ndarray], grammar: Grammar) -> None:
    """Set a dataset's columns, their statistics and LeRobot's own column of instructions."""
    features = schema.demonstration_features(cameras=())
    features[schema.INSTRUCTION]["info"] = {INFO_KEY: grammar.to_data()}

    def of(table: pa.Table) -> dict[str, pa.Array]:
        rows = table["index"].to_numpy()
        return {key: _array(values[rows]) for key, values in columns.items()}

    rewrite(root, of, {key: features[key] for key in columns})
    write_language(root)
    stats = load_stats(root) or {}
    for key, values in columns.items():
        if values.dtype != object:
            numbers = values.astype(np.float64)
            stats[key] = get_feature_stats(numbers, axis=0, keepdims=numbers.ndim == 1)
    write_stats(stats, root)


def _array(values: np.ndarray) -> pa.Array:
    """A column of texts, numbers or vectors (N, D)."""
    if values.ndim == 2:
        return pa.FixedSizeListArray.from_arrays(pa.array(values.reshape(-1)), values.shape[1])
    return pa.array(values, type=pa.string() if values.dtype == object else None)


def _label(episode: FoundKeyframes, instructions: Sequence[str], ignore_collision: bool) -> Labels:
    count = len(episode.keyframes)
    if len(instructions) != count or not all(text.strip() for text in instructions):
        raise LlakeyError(
            f"Expected {count} instructions for episode {episode.episode}, one for each keyframe in "
            f"{episode.keyframes}, got {list(instructions)}; complete them, or find other keyframes by --min_rest."
        )
    return label(episode.states, episode.keyframes, list(instructions), [ignore_collision] * count)


def _columns(found: Sequence[FoundKeyframes], labels: Sequence[Labels]) -> dict[str, np.ndarray]:
    length = sum(len(episode.states) for episode in found)
    return {
        schema.VELOCITY: np.concatenate([estimate_velocities(episode.states, episode.fps) for episode in found]),
        schema.ACTION: np.concatenate([part.action for part in labels]),
        schema.INSTRUCTION: np.array([text for part in labels for text in part.instruction], dtype=object),
        schema.PREVIOUS_INSTRUCTION: np.array(
            [text for part in labels for text in part.previous_instruction], dtype=object
        ),
        schema.STEP: np.concatenate([part.keyframe_index for part in labels]).astype(np.float32),
        schema.IS_KEYFRAME: np.concatenate([part.is_keyframe for part in labels]),
        schema.KEYFRAME_INDEX: np.concatenate([part.keyframe_index for part in labels]),
        schema.NEXT_KEYFRAME: np.concatenate([part.next_frame for part in labels]),
        schema.EPISODE_SEED: np.full(length, -1),
        schema.EPISODE_VARIATION: np.full(length, -1),
        schema.EPISODE_SEQUENCE: np.full(length, -1),
        **{key: np.full(length, "", dtype=object) for key in schema.ORIGIN_COLUMNS},
    }
