"""Keyframes and instructions for a person's own recordings.

Keyframes are discovered from the robot's states; what a person adds is one instruction a segment, in a CSV file with
the columns ``episode,segment,instruction``, in a JSON file ``{"0": ["grasp the cup", ...], ...}``, or typed.
"""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
from lerobot.datasets.compute_stats import get_feature_stats
from lerobot.datasets.io_utils import load_stats, write_stats
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets.language import write_language
from lerobot_llakey.datasets.rewrite import rewrite
from lerobot_llakey.datasets.velocities import estimate_velocities
from lerobot_llakey.errors import FileInTheWayError, LlakeyError, MissingFileError
from lerobot_llakey.keyframes import discover_keyframes
from lerobot_llakey.labels import Labels, label

COLUMNS = ("episode", "segment", "from_second", "to_second", "instruction")
"""Columns of the CSV file that :func:`write_template` writes; reading needs the first two and the last."""


@dataclass(frozen=True)
class FoundKeyframes:
    """An episode's keyframes.

    Attributes:
        episode: its index.
        task: skill instruction.
        states: (T, 15) robot states of the contract.
        keyframes: discovered frames; the last one is T - 1.
        fps: frames a second.
    """

    episode: int
    task: str
    states: np.ndarray
    keyframes: list[int]
    fps: float

    def seconds(self, segment: int) -> tuple[float, float]:
        """When a segment begins and ends."""
        starts = [0, *self.keyframes]
        return starts[segment] / self.fps, starts[segment + 1] / self.fps


def find_keyframes(source: LeRobotDataset, **settings: float) -> list[FoundKeyframes]:
    """Discover every episode's keyframes.

    Args:
        source: a dataset whose state has the contract's columns.
        settings: of :func:`lerobot_llakey.keyframes.discover_keyframes`.

    Raises:
        ValueError: if the dataset has no such state or only some of its episodes are loaded.
    """
    shape = tuple(source.features.get(schema.STATE, {}).get("shape", ()))
    if shape != (schema.STATE_DIM,):
        raise LlakeyError(
            f"Expected {schema.STATE} of {schema.STATE_DIM} numbers ({', '.join(schema.STATE_NAMES)}) in "
            f"{source.repo_id}, got {f'shape {shape}' if shape else 'no such column'}; record these."
        )
    if len(source.hf_dataset) != source.meta.total_frames:
        raise LlakeyError(
            f"Expected all {source.meta.total_episodes} episodes of {source.repo_id}, got {source.num_episodes}; load "
            "it without a choice of episodes."
        )
    rows = source.hf_dataset.select_columns([schema.STATE, "episode_index", "task_index"]).with_format("numpy")[:]
    states = np.asarray(rows[schema.STATE], dtype=np.float32)
    found = []
    for episode in np.unique(rows["episode_index"]):
        frames = np.flatnonzero(rows["episode_index"] == episode)
        part = states[frames]
        keyframes = discover_keyframes(part[:, schema.JOINTS], part[:, schema.GRIPPER], source.fps, **settings)
        task = str(source.meta.tasks.iloc[int(rows["task_index"][frames[0]])].name)
        found.append(FoundKeyframes(int(episode), task, part, keyframes, source.fps))
    return found


def write_template(found: Sequence[FoundKeyframes], path: Path) -> None:
    """Write a CSV file with one line a segment, its instruction left empty for a person to fill in."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for episode in found:
            for segment in range(len(episode.keyframes)):
                begin, end = episode.seconds(segment)
                writer.writerow((episode.episode, segment, f"{begin:.1f}", f"{end:.1f}", ""))


def read_instructions(path: Path) -> dict[int, list[str]]:
    """Instructions by episode, in the order of segments, from a CSV or JSON file.

    Raises:
        FileNotFoundError: if there is no such file.
        ValueError: if it is not of the form that this module's description gives.
    """
    if not path.exists():
        raise MissingFileError(f"Expected instructions in {path}, found no file; write one with --template={path}.")
    if path.suffix == ".json":
        try:
            return {
                int(episode): [str(text) for text in texts] for episode, texts in json.loads(path.read_text()).items()
            }
        except (AttributeError, TypeError, ValueError) as error:
            raise LlakeyError(
                f'Expected {path} to hold {{"0": ["instruction", ...], ...}}, got something else ({error}); correct it.'
            ) from error
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    try:
        by_segment = {(int(row["episode"]), int(row["segment"])): row["instruction"].strip() for row in rows}
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise LlakeyError(
            f"Expected {path} to have the columns episode, segment and instruction, got a row without ({error}); "
            "correct it."
        ) from error
    instructions: dict[int, list[str]] = {}
    for episode, segment in sorted(by_segment):
        if segment != len(instructions.setdefault(episode, [])):
            raise LlakeyError(
                f"Expected segment {len(instructions[episode])} of episode {episode} in {path}, got segment {segment}; "
                "number the segments from 0 without gaps."
            )
        instructions[episode].append(by_segment[episode, segment])
    return instructions


def ask_instructions(found: Sequence[FoundKeyframes], ask: Callable[[str], str] = input) -> dict[int, list[str]]:
    """Ask a person for every segment's instruction; an empty answer takes the one of the same segment before.

    Args:
        found: episodes with their keyframes.
        ask: shows a prompt and returns what was typed.
    """
    instructions: dict[int, list[str]] = {}
    before: dict[tuple[str, int, int], str] = {}
    for episode in found:
        texts: list[str] = []
        count = len(episode.keyframes)
        for segment in range(count):
            begin, end = episode.seconds(segment)
            place = (episode.task, count, segment)
            default = f" [{before[place]}]" if place in before else ""
            prompt = f"episode {episode.episode} ({episode.task}), {begin:.1f} to {end:.1f} s{default}: "
            text = ask(prompt).strip() or before.get(place, "")
            while not text:
                text = ask(prompt).strip()
            before[place] = text
            texts.append(text)
        instructions[episode.episode] = texts
    return instructions


def annotate(
    source: LeRobotDataset,
    found: Sequence[FoundKeyframes],
    instructions: Mapping[int, Sequence[str]],
    root: Path,
    repo_id: str,
    *,
    ignore_collision: bool = True,
) -> LeRobotDataset:
    """Write a copy of a dataset with the contract's keyframe and instruction columns.

    Where the source has no velocities, the copy's are estimated from its states.

    The copy's action is the next keyframe's; the action that was recorded stays in the source alone.

    Args:
        source: the recordings, left as they are.
        found: their keyframes.
        instructions: by episode, one a segment.
        root: folder of the copy, which must not exist yet.
        repo_id: its name.
        ignore_collision: whether the planner may touch things on the way to a keyframe: recordings do not tell.

    Raises:
        ValueError: if an episode's instructions are missing or not as many as its segments.
        FileExistsError: if the folder exists.
    """
    if root.exists():
        raise FileInTheWayError(f"Expected {root} not to exist, found it; choose a new folder.")
    labels = [_label(episode, instructions.get(episode.episode, ()), ignore_collision) for episode in found]
    kept = (schema.EPISODE_SEED, schema.EPISODE_VARIATION, schema.EPISODE_SEQUENCE, *schema.LATER_COLUMNS)
    columns = {
        key: values for key, values in _columns(found, labels).items() if not (key in kept and key in source.features)
    }
    shutil.copytree(source.root, root, ignore=shutil.ignore_patterns("README.md", ".cache"))
    features = schema.demonstration_features(cameras=())

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
    return LeRobotDataset(repo_id, root=root)


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
