"""Keyframes and instructions for a person's own recordings, of any arm.

Keyframes are discovered from the robot's states by a choice of rules; what a person adds is one instruction a segment,
in a CSV file with the columns ``episode,segment,instruction``, in a JSON file ``{"0": ["grasp the cup", ...], ...}``,
or typed. A CSV file with the column ``frame`` also says which frames are keyframes.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets.camera_calibration import CameraCalibration
from lerobot_llakey.datasets.commanded_gripper import command_column, gripper_opened
from lerobot_llakey.datasets.depth_files import DepthFiles
from lerobot_llakey.datasets.found import FoundKeyframes, chosen_keyframes
from lerobot_llakey.datasets.joint_poses import ArmModel
from lerobot_llakey.datasets.poses import state_reader
from lerobot_llakey.datasets.rewrite import as_column, rewrite
from lerobot_llakey.datasets.units import check_states
from lerobot_llakey.datasets.velocities import estimate_velocities, velocity_columns
from lerobot_llakey.datasets.wording import by_place, refuse_outside_grammar
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import check_writable
from lerobot_llakey.folders import new_folder, refuse_occupied
from lerobot_llakey.geometry import continuous_quaternions
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.hand import hand_columns, joint_columns, read_hand
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.keyframes.motion import Motion
from lerobot_llakey.keyframes.rules import RuleSettings, find_by_rules
from lerobot_llakey.labels import Labels, label


def find_keyframes(
    source: LeRobotDataset,
    settings: RuleSettings | None = None,
    rules: tuple[str, ...] = ("rest",),
    given: Mapping[int, list[int]] | None = None,
    arm: ArmModel | None = None,
    **wording: Any,
) -> list[FoundKeyframes]:
    """Discover every episode's keyframes.

    Joints, the further numbers whose names hold "joint", tell rests best. Where no joints are named, the hand's pose
    does: other numbers could be of any unit.

    Args:
        source: a dataset whose state holds the hand's pose, or an arm's joints.
        settings: what counts as a keyframe.
        rules: which rules find keyframes, of :data:`lerobot_llakey.keyframes.rules.RULES`.
        given: keyframes by episode that a person chose; taken as they are in place of what the rules find.
        arm: gives the hand's pose where the state holds joints alone.
        wording: how the state is written, see :func:`lerobot_llakey.datasets.poses.state_reader`.

    Raises:
        LlakeyError: if the dataset has no such state, it is in other units, an episode is too short, or only some of
            the episodes are loaded, or a chosen keyframe lies outside its episode.
    """
    settings = settings or RuleSettings()
    if schema.STATE not in source.features:
        raise LlakeyError(
            f"Expected {schema.STATE} with the hand's pose in {source.repo_id}, got only "
            f"{', '.join(source.features)}; record it."
        )
    feature = source.features[schema.STATE]
    reader = state_reader(feature, **wording) if arm is None else arm.reader(feature, **wording)
    if len(source.hf_dataset) != source.meta.total_frames:
        raise LlakeyError(
            f"Expected all {source.meta.total_episodes} episodes of {source.repo_id}, got {source.num_episodes}; load "
            "it without a choice of episodes."
        )
    command = command_column(source.features.get(schema.ACTION), wording.get("gripper"))
    wanted = [schema.STATE, "episode_index", "task_index", *([] if command is None else [schema.ACTION])]
    rows = source.hf_dataset.select_columns(wanted).with_format("numpy")[:]
    states = reader.read(np.asarray(rows[schema.STATE]).reshape(len(rows["episode_index"]), -1))
    check_states(states, reader.names, rows["episode_index"], source.fps)
    openings = read_hand(states, hand_columns(reader.names))[:, schema.GRIPPER]
    opened = gripper_opened(openings, None if command is None else np.asarray(rows[schema.ACTION])[:, command])
    found = []
    for episode in np.unique(rows["episode_index"]):
        frames = np.flatnonzero(rows["episode_index"] == episode)
        part = states[frames]
        part[:, schema.QUATERNION] = continuous_quaternions(part[:, schema.QUATERNION])
        if len(part) < 2:
            raise LlakeyError(
                f"Expected episodes of two frames or more in {source.repo_id}, got one frame in episode {episode}; "
                "remove it with lerobot-edit-dataset."
            )
        if given is not None and int(episode) in given:
            keyframes = chosen_keyframes(int(episode), given[int(episode)], len(part))
        else:
            commanded = opened[frames] if command is not None else None
            motion = _motion(part, openings[frames], reader.names, source.fps, commanded)
            keyframes = find_by_rules(motion, rules, settings)
        task = str(source.meta.tasks.iloc[int(rows["task_index"][frames[0]])].name)
        found.append(
            FoundKeyframes(
                int(episode), task, part.astype(np.float32), reader.names, opened[frames], keyframes, source.fps
            )
        )
    return found


def _motion(
    states: np.ndarray, openings: np.ndarray, names: Sequence[str], fps: float, commanded: np.ndarray | None
) -> Motion:
    joints = joint_columns(names)
    return Motion(
        states[:, list(hand_columns(names)[:7])], openings, fps, states[:, joints] if joints else None, commanded
    )


def annotate(
    source: LeRobotDataset,
    found: Sequence[FoundKeyframes],
    instructions: Mapping[int, Sequence[str]],
    root: Path,
    repo_id: str,
    *,
    ignore_collision: bool = True,
    calibration: Mapping[str, CameraCalibration] | None = None,
    depth: DepthFiles | None = None,
    grammar: Grammar = BASIC_GRAMMAR,
) -> LeRobotDataset:
    """Write a copy of a dataset with the contract's state, keyframe and instruction columns.

    The copy appears whole or not at all. Where the source has no velocities, the copy's are estimated from its states.

    The copy's action is the next keyframe's; the action that was recorded stays in the source alone.

    Args:
        source: the recordings, left as they are.
        found: their keyframes.
        instructions: by episode, one a segment.
        root: folder of the copy, which must not exist yet.
        repo_id: its name.
        ignore_collision: whether the planner may touch things on the way to a keyframe: recordings do not tell.
        calibration: of cameras that do not move, by name; other cameras stay as they are.
        depth: pictures that the copy gets as videos.
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
    names = found[0].names
    velocity_names, _ = velocity_columns(names)
    features = schema.label_features(grammar.to_data()) | {schema.STATE: schema.vector(names)}
    kept = {schema.EPISODE_SEED, schema.EPISODE_VARIATION, schema.EPISODE_SEQUENCE, *schema.ORIGIN_COLUMNS}
    kept &= set(source.features)
    columns = {key: values for key, values in _columns(found, labels).items() if key not in kept}
    if velocity_names and tuple(source.features.get(schema.VELOCITY, {}).get("shape", ())) != (len(velocity_names),):
        features[schema.VELOCITY] = schema.vector(velocity_names)
        columns[schema.VELOCITY] = _velocities(found)
    for camera, known in (calibration or {}).items():
        for key, value in (
            (schema.intrinsics_key(camera), known.intrinsics),
            (schema.extrinsics_key(camera), known.extrinsics),
        ):
            features[key] = schema.vector(schema.INTRINSICS_NAMES if len(value) == 4 else schema.POSE_NAMES)
            columns[key] = np.tile(value, (source.meta.total_frames, 1))
    check_writable(root, sum(file.stat().st_size for file in source.root.rglob("*") if file.is_file()))
    with new_folder(root) as folder:
        shutil.copytree(source.root, folder, ignore=shutil.ignore_patterns("README.md", ".cache"))

        def of(table: pa.Table) -> dict[str, pa.Array]:
            rows = table["index"].to_numpy()
            return {key: as_column(values[rows]) for key, values in columns.items()}

        videos = {} if depth is None else depth.write(folder, source.meta)
        rewrite(folder, of, {key: features[key] for key in columns}, videos=videos)
    return LeRobotDataset(repo_id, root=root)


def _label(episode: FoundKeyframes, instructions: Sequence[str], ignore_collision: bool) -> Labels:
    count = len(episode.keyframes)
    if len(instructions) != count or not all(text.strip() for text in instructions):
        raise LlakeyError(
            f"Expected {count} instructions for episode {episode.episode}, one for each keyframe in "
            f"{episode.keyframes}, got {list(instructions)}; complete them, or choose other keyframes "
            "by --keyframes or the file's column frame."
        )
    hand = read_hand(episode.states, hand_columns(episode.names))
    return label(
        hand,
        episode.keyframes,
        list(instructions),
        [ignore_collision] * count,
        episode.opened[episode.keyframes].tolist(),
    )


def _velocities(found: Sequence[FoundKeyframes]) -> np.ndarray:
    _, places = velocity_columns(found[0].names)
    return np.concatenate([estimate_velocities(episode.states[:, places], episode.fps) for episode in found])


def _columns(found: Sequence[FoundKeyframes], labels: Sequence[Labels]) -> dict[str, np.ndarray]:
    length = sum(len(episode.states) for episode in found)
    return {
        schema.STATE: np.concatenate([episode.states for episode in found]),
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
