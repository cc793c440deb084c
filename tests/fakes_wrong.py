"""Datasets that are wrong in one way each, made of a sound one."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import TASKS
from lerobot_llakey.geometry import matrix_to_pose, pose_to_matrix

Rows = dict[str, np.ndarray]
Change = Callable[[Rows], None]
S, A = schema.STATE, schema.ACTION
K, E = schema.intrinsics_key("front"), schema.extrinsics_key("front")
OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])
WXYZ = [0, 1, 2, 6, 3, 4, 5]


def _put(key: str, place: Any, value: Any) -> Change:
    def change(rows: Rows) -> None:
        rows[key][place] = value

    return change


def _times(key: str, place: Any, factor: float) -> Change:
    def change(rows: Rows) -> None:
        rows[key][place] *= factor

    return change


def _with(key: str, new: Callable[[np.ndarray], np.ndarray]) -> Change:
    def change(rows: Rows) -> None:
        rows[key] = new(rows[key])

    return change


def _swap(rows: Rows) -> None:
    rows[S][:, :8], rows[A][:, :8] = rows[A][:, :8].copy(), rows[S][:, :8].copy()


def _shuffle(rows: Rows) -> None:
    rows[A] = rows[A][np.random.default_rng(0).permutation(len(rows[A]))]


def _turned(rows: Rows) -> None:
    for key, values in rows.items():
        rows[key] = values[::-1].copy()


def _doubled(rows: Rows) -> None:
    for key, values in rows.items():
        rows[key] = np.repeat(values, 2, axis=0)


def _wxyz(values: np.ndarray) -> np.ndarray:
    return np.concatenate((values[:, WXYZ], values[:, 7:]), axis=1)


def _texts(text: object) -> Callable[[np.ndarray], np.ndarray]:
    return lambda values: np.array([None, *[text] * len(values)], dtype=object)[1:]


def _matrices(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[np.ndarray], np.ndarray]:
    """What is done to matrices, done to poses."""
    return lambda poses: matrix_to_pose(change(pose_to_matrix(poses)))


def _transposed(matrices: np.ndarray) -> np.ndarray:
    new = matrices.copy()
    new[..., :3, :3] = np.swapaxes(matrices[..., :3, :3], -1, -2)
    return new


def _of_another(rows: Rows) -> None:
    rows[E] = rows[schema.extrinsics_key("left_shoulder")].copy()


def _whole(values: np.ndarray) -> np.ndarray:
    return np.full_like(values, True)


WRONG: dict[str, tuple[str, Change]] = {
    "state NaN": (S, _put(S, (3, 0), np.nan)),
    "state infinite": (S, _put(S, (3, 2), np.inf)),
    "state joint NaN": (S, _put(S, (3, 9), np.nan)),
    "state gripper NaN": (S, _put(S, (3, 7), np.nan)),
    "state in millimetres": (S, _times(S, np.s_[:, :3], 1000)),
    "state in centimetres": (S, _times(S, np.s_[:, :3], 100)),
    "state position zero": (S, _put(S, np.s_[:, :3], 0)),
    "state quaternion zero": (S, _put(S, np.s_[2, 3:7], 0)),
    "state quaternion NaN": (S, _put(S, np.s_[2, 3:7], np.nan)),
    "state quaternion x100": (S, _times(S, np.s_[:, 3:7], 100)),
    "state quaternion wxyz": (A, _with(S, _wxyz)),
    "gripper 0..255": (S, _times(S, np.s_[:, 7], 255)),
    "gripper 0..100": (S, _times(S, np.s_[:, 7], 100)),
    "gripper in metres": (S, _times(S, np.s_[:, 7], 0.08)),
    "gripper inverted": (S, _with(S, lambda v: np.concatenate((v[:, :7], 1 - v[:, 7:8], v[:, 8:]), axis=1))),
    "joints in degrees": (S, _times(S, np.s_[:, 8:], 57.3)),
    "state and action swapped": (A, _swap),
    "action NaN": (A, _put(A, (1, 1), np.nan)),
    "action zero": (A, _put(A, np.s_[:], 0)),
    "action in millimetres": (A, _times(A, np.s_[:, :3], 1000)),
    "action quaternion NaN": (A, _put(A, np.s_[1, 3:7], np.nan)),
    "action quaternion infinite": (A, _put(A, np.s_[1, 3:7], np.inf)),
    "action quaternion zero": (A, _put(A, np.s_[:, 3:7], 0)),
    "action quaternion tiny": (A, _times(A, np.s_[:, 3:7], 1e-20)),
    "action quaternion wxyz": (A, _with(A, _wxyz)),
    "action gripper NaN": (A, _put(A, (1, 7), np.nan)),
    "action gripper 0..255": (A, _times(A, np.s_[:, 7], 255)),
    "labels shuffled": (A, _shuffle),
    "intrinsics NaN": (K, _put(K, (0, 0), np.nan)),
    "intrinsics of twice the pictures": (K, _times(K, np.s_[:], 2)),
    "a principal point of twice the pictures": (K, _times(K, np.s_[:, 2:], 2)),
    "intrinsics in another order": (K, _with(K, lambda v: v[:, [0, 2, 1, 3]] * [1, 0.3, 1, 1])),
    "intrinsics with a focal length of 1e9": (K, _put(K, np.s_[:, 0], 1e9)),
    "intrinsics zero": (K, _put(K, np.s_[:], 0)),
    "extrinsics NaN": (E, _put(E, (0, 3), np.nan)),
    "extrinsics inverted": (E, _with(E, _matrices(np.linalg.inv))),
    "extrinsics with a transposed rotation": (E, _with(E, _matrices(_transposed))),
    "extrinsics in OpenGL axes": (E, _with(E, _matrices(lambda v: v @ OPENGL))),
    "extrinsics that begin with w": (E, _with(E, lambda v: v[:, WXYZ])),
    "extrinsics identity": (E, _put(E, np.s_[:], [0, 0, 0, 0, 0, 0, 1])),
    "extrinsics zero": (E, _put(E, np.s_[:], 0)),
    "extrinsics of one camera for all": (schema.extrinsics_key("left_shoulder"), _of_another),
    "extrinsics in millimetres": (E, _times(E, np.s_[:, :3], 1000)),
    "no keyframe": (schema.IS_KEYFRAME, _put(schema.IS_KEYFRAME, np.s_[:], False)),
    "all keyframes": (schema.IS_KEYFRAME, _with(schema.IS_KEYFRAME, _whole)),
    "next_frame backwards": (schema.NEXT_KEYFRAME, _put(schema.NEXT_KEYFRAME, np.s_[4], 0)),
    "next_frame beyond the episode": (schema.NEXT_KEYFRAME, _put(schema.NEXT_KEYFRAME, np.s_[4:6], 99)),
    "next_frame no keyframe": (schema.NEXT_KEYFRAME, _put(schema.NEXT_KEYFRAME, np.s_[:3], 4)),
    "keyframe index going back": (schema.KEYFRAME_INDEX, _put(schema.KEYFRAME_INDEX, 4, 0)),
    "step negative": (schema.STEP, _put(schema.STEP, 1, -1)),
    "rows reversed": ("frame_index", _turned),
    "rows doubled": ("frame_index", _doubled),
    "times standing still": ("timestamp", _put("timestamp", np.s_[:], 0)),
    "rows counted wrongly": ("index", _put("index", 3, 0)),
    "instructions shuffled": (schema.INSTRUCTION, _with(schema.INSTRUCTION, np.random.default_rng(0).permutation)),
    "task below 0": (TASKS, _put(TASKS, 2, -1)),
    "instruction null": (schema.INSTRUCTION, _put(schema.INSTRUCTION, 2, None)),
    "instruction empty": (schema.INSTRUCTION, _put(schema.INSTRUCTION, 2, "")),
    "instruction outside the grammar": (schema.INSTRUCTION, _with(schema.INSTRUCTION, _texts("do the dishes"))),
    "instruction of another script": (schema.INSTRUCTION, _with(schema.INSTRUCTION, _texts("抓住红色方块"))),
    "instruction of 10,000 characters": (schema.INSTRUCTION, _with(schema.INSTRUCTION, _texts("a" * 10000))),
    "instruction with the stop token": (schema.INSTRUCTION, _put(schema.INSTRUCTION, 2, "grasp the cup <next goal>")),
    "previous instruction with an image": (
        schema.PREVIOUS_INSTRUCTION,
        _put(schema.PREVIOUS_INSTRUCTION, 2, "grasp the <image>"),
    ),
}  # fmt: skip
"""What is wrong: the column that a refusal names, and what makes a dataset so."""

NAMES: dict[str, tuple[str, dict[str, Any]]] = {
    "no names": (S, {"names": None}),
    "names without a rotation": (S, {"names": [*"xyz", "roll", "pitch", "yaw", "k", *schema.SIM_STATE_NAMES[7:]]}),
    "names that say x twice": (S, {"names": ["x", "x", *schema.SIM_STATE_NAMES[2:]]}),
    "names swapped": (A, {"names": [*schema.ACTION_NAMES[:7], "ignore_collision", "gripper_open"]}),
    "names of a pose swapped": (E, {"names": [*"xyz", "qw", "qx", "qy", "qz"]}),
    "depth not noted as depth": (schema.depth_key("front"), {"info": None}),
}
"""What ``info.json`` can say wrongly: the column, and what is said of it."""


def read_rows(root: Path) -> Rows:
    """The columns of a dataset of one file, without pictures."""
    table = pq.read_table(next((root / "data").rglob("*.parquet")))
    rows: Rows = {}
    for name in table.column_names:
        kind = table.schema.field(name).type
        if not pa.types.is_struct(kind):
            values = table[name].to_pylist()
            is_text = pa.types.is_string(kind)
            rows[name] = np.array([None, *values], dtype=object)[1:] if is_text else np.array(values)
    return rows


def write_rows(root: Path, rows: Rows) -> None:
    """Put columns in place of those of a dataset of one file; pictures are repeated where rows are."""
    path = next((root / "data").rglob("*.parquet"))
    table = pq.read_table(path)
    length = len(next(iter(rows.values())))
    if length != table.num_rows:
        table = table.take(np.repeat(np.arange(table.num_rows), length // table.num_rows))
    for name, values in rows.items():
        kind = table.schema.field(name).type
        kind = kind.storage_type if isinstance(kind, pa.ExtensionType) else kind
        table = table.set_column(table.column_names.index(name), name, pa.array(values.tolist(), type=kind))
    pq.write_table(table.replace_schema_metadata(None), path)


def wrong_dataset(sound: Path, root: Path, change: Change) -> Path:
    """A copy of a dataset with its rows changed."""
    shutil.copytree(sound, root)
    rows = read_rows(root)
    change(rows)
    write_rows(root, rows)
    return root


def misnoted_dataset(sound: Path, root: Path, column: str, notes: dict[str, Any]) -> Path:
    """A copy of a dataset that says something else of a column."""
    shutil.copytree(sound, root)
    path = root / "meta" / "info.json"
    info = json.loads(path.read_text())
    info["features"][column] |= notes
    path.write_text(json.dumps(info))
    return root
