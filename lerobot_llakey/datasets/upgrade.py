"""Datasets of the first data contract, brought to the present one.

The first one stacked calibration over cameras, kept texts under ``observation.`` and flipped quaternions to w >= 0.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from lerobot.datasets.language import LANGUAGE_PERSISTENT

from lerobot_llakey import schema
from lerobot_llakey.datasets.opening import open_metadata
from lerobot_llakey.datasets.rewrite import as_column, rewrite
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import check_writable
from lerobot_llakey.folders import new_folder, refuse_occupied
from lerobot_llakey.geometry import continuous_quaternions, matrix_to_pose, nearest_sign

_INTRINSICS, _EXTRINSICS = "observation.camera_intrinsics", "observation.camera_extrinsics"
_TEXTS = {f"observation.{key}": key for key in schema.TEXTS}
_GONE = (_INTRINSICS, _EXTRINSICS, *_TEXTS, LANGUAGE_PERSISTENT)


def upgrade(source: Path, root: Path) -> None:
    """Write a dataset of the first contract anew in the present one; it appears whole or not at all.

    Args:
        source: folder of demonstrations or keysteps, left as it is.
        root: folder of the new dataset, which must not exist yet.

    Raises:
        LlakeyError: if the dataset cannot be read or is not of the first contract, or the folder cannot be written to.
        FileInTheWayError: if the folder exists.
    """
    refuse_occupied(root)
    features = open_metadata(source).features
    if not {_INTRINSICS, _EXTRINSICS, *_TEXTS} & set(features):
        raise LlakeyError(
            f"Expected a dataset of the first contract, with {_INTRINSICS} or {', '.join(_TEXTS)}, in {source}, got "
            "none of these columns; use it as it is."
        )
    cameras = _cameras(features, source)
    new = _new_features(features, cameras)
    check_writable(root, sum(file.stat().st_size for file in source.rglob("*") if file.is_file()))
    with new_folder(root) as folder:
        shutil.copytree(source, folder, ignore=shutil.ignore_patterns("README.md", ".cache"))
        rewrite(folder, lambda table: _columns(table, cameras, new), new, [key for key in _GONE if key in features])


def _cameras(features: Mapping[str, Any], source: Path) -> tuple[str, ...]:
    """The cameras in the order in which calibration was stacked; none without calibration."""
    stacked = [features[key]["shape"][0] for key in (_INTRINSICS, _EXTRINSICS) if key in features]
    cameras = schema.cameras_of(features)
    cameras = tuple(camera for camera in cameras if schema.depth_key(camera) in features) or cameras
    if any(count != len(cameras) for count in stacked):
        raise LlakeyError(
            f"Expected calibration of the {len(cameras)} cameras {', '.join(cameras)} in {source}, got {stacked[0]} "
            "matrices; remove the images without calibration with lerobot-edit-dataset."
        )
    return cameras if stacked else ()


def _new_features(features: Mapping[str, Any], cameras: Sequence[str]) -> dict[str, dict[str, Any]]:
    labels = schema.label_features()
    new = {_TEXTS[key]: labels[_TEXTS[key]] for key in _TEXTS if key in features}
    new |= {key: dict(features[key]) for key in (schema.STATE, schema.ACTION) if key in features}
    for camera in cameras:
        if _INTRINSICS in features:
            new[schema.intrinsics_key(camera)] = schema.vector(schema.INTRINSICS_NAMES)
        if _EXTRINSICS in features:
            new[schema.extrinsics_key(camera)] = schema.vector(schema.POSE_NAMES)
    return new


def _columns(table: pa.Table, cameras: Sequence[str], new: Mapping[str, Any]) -> dict[str, pa.Array]:
    columns = {after: table[before] for before, after in _TEXTS.items() if after in new}
    read = {key: np.array(table[key].to_pylist()) for key in table.column_names if key in (*new, *_KEYS)}
    changed = {key: np.zeros((table.num_rows, *new[key]["shape"]), np.float32) for key in new if key not in columns}
    episodes = read["episode_index"]
    for episode in np.unique(episodes):
        rows = np.flatnonzero(episodes == episode)
        of = {key: values[rows] for key, values in read.items()}
        made = _signed(of) | {
            key: value for place, camera in enumerate(cameras) for key, value in _calibration(of, place, camera).items()
        }
        for key, values in made.items():
            changed[key][rows] = values
    return columns | {key: as_column(values) for key, values in changed.items()}


_KEYS = ("episode_index", schema.IS_KEYFRAME, schema.KEYFRAME_INDEX, _INTRINSICS, _EXTRINSICS)


def _calibration(of: Mapping[str, np.ndarray], place: int, camera: str) -> dict[str, np.ndarray]:
    """Calibration of one camera through an episode."""
    found: dict[str, np.ndarray] = {}
    if _INTRINSICS in of:
        matrices = of[_INTRINSICS][:, place]
        found[schema.intrinsics_key(camera)] = matrices[:, (0, 1, 0, 1), (0, 1, 2, 2)]
    if _EXTRINSICS in of:
        poses = matrix_to_pose(of[_EXTRINSICS][:, place].astype(np.float64))
        poses[:, schema.QUATERNION] = continuous_quaternions(poses[:, schema.QUATERNION])
        found[schema.extrinsics_key(camera)] = poses
    return found


def _signed(of: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """States and actions of an episode with quaternions without jumps.

    A segment's action takes the sign of the state at its keyframe: the sample that starts the next segment or, of the
    last segment, its last one.
    """
    changed = {key: of[key].copy() for key in (schema.STATE, schema.ACTION) if key in of}
    if schema.STATE not in changed:
        return changed
    quaternions = changed[schema.STATE][:, schema.QUATERNION]
    quaternions[:] = continuous_quaternions(quaternions)
    if schema.ACTION in changed:
        segments = of[schema.KEYFRAME_INDEX].reshape(-1)
        starts = of[schema.IS_KEYFRAME].reshape(-1)
        for segment in np.unique(segments):
            reached = np.flatnonzero(starts & (segments == segment + 1))
            rows = np.flatnonzero(segments == segment)
            reference = quaternions[reached[0] if len(reached) else rows[-1]]
            for row in rows:
                action = changed[schema.ACTION][row]
                action[schema.QUATERNION] = nearest_sign(action[schema.QUATERNION], reference)
    return changed
