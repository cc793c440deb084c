"""Datasets whose columns, metadata, files or pictures are wrong, checked and trained on as a person would."""

from __future__ import annotations

import io
import json
import math
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from PIL import Image

from fuzz.case import Case

Change = Callable[[Path], None]
"""What is done to a whole dataset's folder."""
INFO = "meta/info.json"


def _check(source: Path, change: Change, folder: Path) -> str | None:
    """``llakey check``: refused with status 1, or named in a warning."""
    from lerobot_llakey.cli.main import main

    root = _changed(source, change, folder)
    main(["check", "--repo_id=fuzz/data", f"--root={root}"])
    sys.stdout.flush()
    return "warned" if "warning" in (folder.parent / "said").read_text().lower() else None


def _train(source: Path, change: Change, kind: str, folder: Path) -> str | None:
    """What ``lerobot-train`` does before its first step, and that step."""
    import torch
    from lerobot.policies.factory import make_policy, make_pre_post_processors
    from lerobot.utils.collate import lerobot_collate_fn

    from fakes_action import small_config
    from lerobot_llakey.datasets.opening import open_dataset
    from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig

    root = _changed(source, change, folder)
    dataset = open_dataset("fuzz/data", root)  # lerobot-train opens broken files before it asks us
    config: Any = LlakeyCommandConfig(device="cpu", image_size=32, vision_layers=1, text_layers=1)
    if kind == "action":
        config = small_config()
        config.input_features = config.output_features = None
    config.push_to_hub = False
    policy = make_policy(config, ds_meta=dataset.meta)
    before, _ = make_pre_post_processors(config, dataset_stats=dataset.meta.stats)
    loader = torch.utils.data.DataLoader(dataset, len(dataset), collate_fn=lerobot_collate_fn)
    policy.forward(before(next(iter(loader))))
    return "warned" if "WARNING:root:Expected" in (folder.parent / "said").read_text() else None


def _changed(source: Path, change: Change, folder: Path) -> Path:
    root = folder / "data"
    shutil.copytree(source, root)
    change(root)
    return root


def _data_files(root: Path) -> list[Path]:
    return sorted((root / "data").rglob("*.parquet"))


def _column(key: str, change: Callable[[list[Any]], list[Any]]) -> Change:
    """Change all values of a column at once; each is a number, a text, or nested lists of numbers."""

    def apply(root: Path) -> None:
        for path in _data_files(root):
            table = pq.read_table(path)
            index = table.column_names.index(key)
            kind = table.schema.field(index).type
            kind = kind.storage_type if isinstance(kind, pa.ExtensionType) else kind
            values = change(table.column(index).to_pylist())
            table = table.set_column(index, key, pa.array(values, type=kind))
            pq.write_table(table.replace_schema_metadata(None), path)

    return apply


def _array(key: str, change: Callable[[np.ndarray], np.ndarray | None]) -> Change:
    """Change a column of numbers as an array (N, ...), in place or by what is returned."""

    def values(column: list[Any]) -> list[Any]:
        array = np.array(column, dtype=np.float64)
        changed = change(array)
        return (array if changed is None else changed).tolist()

    return _column(key, values)


def _extra(key: str, values: Callable[[int], np.ndarray]) -> Change:
    """A column more, of one number a row."""

    def apply(root: Path) -> None:
        from lerobot_llakey.datasets.rewrite import rewrite

        feature = {key: {"dtype": "float32", "shape": (1,), "names": None}}
        rewrite(root, lambda table: {key: pa.array(values(len(table)).astype(np.float32))}, feature)

    return apply


def _info(change: Callable[[dict[str, Any]], Any]) -> Change:
    def apply(root: Path) -> None:
        info = json.loads((root / INFO).read_text())
        change(info)
        (root / INFO).write_text(json.dumps(info))

    return apply


def _pictures(key: str, change: Callable[[np.ndarray], np.ndarray]) -> Change:
    """Change every picture of a camera, as an array (H, W) or (H, W, 3)."""

    def again(cell: dict[str, Any]) -> dict[str, Any]:
        picture = Image.open(io.BytesIO(cell["bytes"]))
        pixels = np.asarray(picture)
        written, file = np.clip(change(pixels.astype(np.float64)), 0, 65535).astype(pixels.dtype), io.BytesIO()
        Image.fromarray(written).save(file, format=picture.format)
        return {"bytes": file.getvalue(), "path": cell["path"]}

    return _column(key, lambda cells: [again(cell) for cell in cells])


def _every(*changes: Change) -> Change:
    def apply(root: Path) -> None:
        for change in changes:
            change(root)

    return apply


def _set(where: Any, value: float) -> Callable[[np.ndarray], None]:
    def change(array: np.ndarray) -> None:
        array[where] = value

    return change


def _times(part: Any, factor: float) -> Callable[[np.ndarray], None]:
    def change(array: np.ndarray) -> None:
        array[:, part] *= factor

    return change


def _file(name: str, change: Callable[[bytes], bytes]) -> Change:
    def apply(root: Path) -> None:
        path = next(iter(sorted(root.glob(name))))
        path.write_bytes(change(path.read_bytes()))

    return apply


def _gone(name: str, instead: Callable[[Path], Any] | None = None) -> Change:
    def apply(root: Path) -> None:
        path = next(iter(sorted(root.glob(name))))
        path.unlink()
        if instead is not None:
            instead(path)

    return apply


def write_dataset(folder: Path) -> Path:
    """Keysteps of two tasks, as the experts demonstrate them."""
    from lerobot_llakey.checks.checksums import CHECKSUMS
    from lerobot_llakey.datasets.collect import collect
    from lerobot_llakey.datasets.plan import CollectSettings, Targets

    root = folder / "whole"
    settings = CollectSettings(("open_drawer", "close_jar"), num_episodes=2, image_size=64)
    collect(settings, Targets(None, root, keysteps_id="fuzz/data"), num_workers=1, progress=lambda *_: None)
    (root / CHECKSUMS).unlink()  # which would tell every change, and not what is wrong
    return root


def _numbers() -> Iterator[tuple[str, str, Change]]:
    """Column, what is wrong, and how it becomes so."""
    from lerobot_llakey import schema

    position, quaternion, gripper = schema.POSITION, schema.QUATERNION, schema.GRIPPER
    for key in (schema.STATE, schema.ACTION):
        for value in (math.nan, math.inf):
            for name, part in (("position", 1), ("quaternion", 4), ("gripper", gripper)):
                yield key, f"{name} {value} in one row", _array(key, _set((5, part), value))
                yield key, f"{name} {value} in every row", _array(key, _set((slice(None), part), value))
        for name, part, factor in (
            ("millimetres", position, 1000.0), ("centimetres", position, 100.0), ("positions of zero", position, 0.0),
            ("quaternions of zero", quaternion, 0.0), ("quaternions of length 100", quaternion, 100.0),
            ("gripper 0..255", gripper, 255.0), ("gripper 0..100", gripper, 100.0), ("gripper below 0", gripper, -1.0),
        ):  # fmt: skip
            yield key, name, _array(key, _times(part, factor))
        yield key, "quaternions wxyz", _array(key, lambda array: _rolled(array, quaternion))
        yield key, "all zero", _array(key, lambda array: array * 0)
        yield key, "shuffled rows", _array(key, lambda array: array[np.random.default_rng(0).permutation(len(array))])
    yield schema.STATE, "joints in degrees", _array(schema.STATE, _times(slice(schema.HAND_DIM, None), 180 / math.pi))
    yield schema.STATE, "joints NaN", _array(schema.STATE, _set((3, 9), math.nan))
    yield schema.ACTION, "gripper inverted", _array(schema.ACTION, lambda array: _inverted(array, gripper))
    yield schema.ACTION, "collision flag 7", _array(schema.ACTION, _set((slice(None), schema.IGNORE_COLLISION), 7.0))
    yield schema.VELOCITY, "NaN", _array(schema.VELOCITY, _set((2, 3), math.nan))
    key = schema.intrinsics_key("front")
    for name, change in {
        "NaN": _set((4, 1), math.nan),
        "zero": lambda array: array * 0,
        "doubled": lambda array: array * 2,
        "halved": lambda array: array * 0.5,
        "in another order": lambda array: array[:, [2, 3, 0, 1]],
        "of a negative focal length": _set((slice(None), 0), -60.0),
        "of two focal lengths": _set((slice(None), 0), 400.0),
    }.items():
        yield key, name, _array(key, change)
    key = schema.extrinsics_key("front")
    other = schema.extrinsics_key("right_shoulder")
    for name, change in {
        "NaN": _set((4, 3), math.nan),
        "zero": lambda array: array * 0,
        "identity": lambda array: np.broadcast_to(np.array([0, 0, 0, 0, 0, 0, 1.0]), array.shape).copy(),
        "inverted": lambda array: _inverse(array),
        "of inverted rotations": lambda array: array * np.array([1, 1, 1, -1, -1, -1, 1]),
        "in millimetres": _times(slice(0, 3), 1000.0),
        "of quaternions of length 2": _times(slice(3, 7), 2.0),
        "of quaternions wxyz": lambda array: _rolled(array, slice(3, 7)),
        "far off": lambda array: array + np.array([40.0, 40, 40, 0, 0, 0, 0]),
    }.items():
        yield key, name, _array(key, change)
    yield key, "of another camera", _swapped(key, other)
    for name, values in {
        "NaN": lambda count: np.full(count, np.nan),
        "one NaN": lambda count: np.where(np.arange(count) == 3, np.nan, 1.0),
        "negative": lambda count: np.full(count, -1.0),
        "zero": np.zeros,
        "infinite": lambda count: np.full(count, np.inf),
    }.items():
        yield schema.SAMPLE_WEIGHT, name, _extra(schema.SAMPLE_WEIGHT, values)
    for name, change in {
        "none": lambda values: [False] * len(values),
        "all": lambda values: [True] * len(values),
    }.items():
        yield schema.IS_KEYFRAME, name, _column(schema.IS_KEYFRAME, change)
    for name, change in {
        "backwards": lambda values: [0] * len(values),
        "far beyond": lambda values: [10**6] * len(values),
        "negative": lambda values: [-5] * len(values),
    }.items():
        yield schema.NEXT_KEYFRAME, name, _column(schema.NEXT_KEYFRAME, change)
    yield schema.KEYFRAME_INDEX, "falling", _column(schema.KEYFRAME_INDEX, lambda values: values[::-1])
    for key in ("index", "frame_index", "episode_index", "task_index"):
        yield key, "negative", _column(key, lambda values: [-1 for _ in values])
        yield key, "reversed", _column(key, lambda values: values[::-1])
    yield "timestamp", "NaN", _column("timestamp", lambda values: [math.nan for _ in values])


def _texts() -> Iterator[tuple[str, str, Change]]:
    from lerobot_llakey import schema

    for name, text in {
        "outside the grammar": "pick up the block", "Chinese": "抓住红色的杯子",
        "of 10,000 characters": "grasp it " * 1100,
        "with the stop token": "grasp the <next goal> block", "with an image token": "grasp the <image> block",
        "empty": "", "null": None, "of control characters": "grasp \x1b[2J\x00",
    }.items():  # fmt: skip
        yield schema.INSTRUCTION, name, _column(schema.INSTRUCTION, lambda values, text=text: [text] * len(values))
        yield (
            schema.INSTRUCTION,
            f"{name} in one row",
            _column(schema.INSTRUCTION, lambda values, text=text: [text, *values[1:]]),
        )
    yield (
        schema.INSTRUCTION,
        "shuffled",
        _column(schema.INSTRUCTION, lambda values: list(np.random.default_rng(1).permutation(values))),
    )


def _metadata() -> Iterator[tuple[str, str, Change]]:
    from lerobot_llakey import schema

    def named(key: str, names: list[str]) -> Change:
        return _info(lambda info: info["features"][key].update(names=names))

    state, action = list(schema.SIM_STATE_NAMES), list(schema.ACTION_NAMES)
    wxyz = ["x", "y", "z", "qw", "qx", "qy", "qz"]
    yield schema.STATE, "names that say qw first", named(schema.STATE, wxyz + state[7:])
    yield schema.ACTION, "names that say qw first", named(schema.ACTION, wxyz + action[7:])
    yield schema.STATE, "names in another order", named(schema.STATE, state[::-1])
    yield schema.ACTION, "names swapped", named(schema.ACTION, [action[7], *action[1:7], action[0], action[8]])
    for key in (schema.STATE, schema.ACTION, schema.intrinsics_key("front"), schema.depth_key("front")):
        yield key, "gone from info.json", _info(lambda info, key=key: info["features"].pop(key))
    yield (
        schema.STATE,
        "of another shape in info.json",
        _info(lambda info: info["features"][schema.STATE].update(shape=[3])),
    )
    yield (
        schema.depth_key("wrist"),
        "no longer called depth",
        _info(lambda info: info["features"][schema.depth_key("wrist")].update(info=None)),
    )
    for key in ("data_path", "video_path"):
        for value in ("../../etc/{chunk_index}/{file_index}", "/etc/passwd", ""):
            if (key, value) != ("video_path", ""):
                yield (
                    key,
                    f"{value!r} in info.json",
                    _info(lambda info, key=key, value=value: info.update({key: value})),
                )
    for key, value in (
        ("fps", 0),
        ("fps", -1),
        ("fps", "ten"),
        ("codebase_version", "v9.0"),
        ("features", {}),
        ("features", 3),
        ("total_frames", 10**9),
    ):
        yield key, f"{value!r} in info.json", _info(lambda info, key=key, value=value: info.update({key: value}))
    yield (
        schema.image_key("front"),
        "cells that name a file",
        _column(schema.image_key("front"), lambda cells: [{"bytes": None, "path": "/etc/passwd"} for _ in cells]),
    )
    for name in (INFO, "data/**/*.parquet", "meta/tasks.parquet", "meta/episodes/**/*.parquet"):
        said = name.rpartition("/")[2]
        for part in (0, 9, 500):
            yield said.strip("*"), f"cut to {part} bytes", _file(name, lambda data, part=part: data[:part])
        yield (
            said.strip("*"),
            "flipped",
            _file(name, lambda data: data[:2] + b"\xff\xfe\xfd" + data[5:-9] + bytes(9)),
        )
        yield said.strip("*"), "missing", _gone(name)
        yield said.strip("*"), "a folder", _gone(name, Path.mkdir)
        yield said.strip("*"), "a named pipe", _gone(name, os.mkfifo)


def _looks() -> Iterator[tuple[str, str, Change]]:
    """What only the pictures tell."""
    from lerobot_llakey import schema

    depths = [schema.depth_key(camera) for camera in schema.CAMERAS]
    for name, change in {
        "in centimetres": lambda pixels: pixels / 10, "in decimetres": lambda pixels: pixels / 100,
        "in metres": lambda pixels: pixels / 1000, "constant": lambda pixels: pixels * 0 + 500,
        "zero": lambda pixels: pixels * 0, "mirrored": lambda pixels: pixels[:, ::-1],
        "upside down": lambda pixels: pixels[::-1], "of 8 bits": lambda pixels: pixels / 16,
        "a disparity": lambda pixels: 50_000 / np.maximum(pixels, 1),
        "noise": lambda pixels: np.random.default_rng(0).integers(300, 2000, pixels.shape),
    }.items():  # fmt: skip
        yield "depth", name, _every(*(_pictures(key, change) for key in depths))
    yield "depth", "zero in three cameras", _every(*(_pictures(key, lambda pixels: pixels * 0) for key in depths[:3]))
    yield (
        "image",
        "black",
        _every(*(_pictures(schema.image_key(camera), lambda pixels: pixels * 0) for camera in schema.CAMERAS)),
    )


def _updated(key: str, value: Any) -> Callable[[dict[str, Any]], None]:
    return lambda info: info.update({key: value})


def _rolled(array: np.ndarray, part: slice) -> np.ndarray:
    array[:, part] = np.roll(array[:, part], 1, axis=1)
    return array


def _inverted(array: np.ndarray, column: int) -> np.ndarray:
    array[:, column] = 1 - array[:, column]
    return array


def _inverse(poses: np.ndarray) -> np.ndarray:
    """Base-to-camera poses in place of camera-to-base ones."""
    from lerobot_llakey.geometry import matrix_to_pose, pose_to_matrix

    return matrix_to_pose(np.linalg.inv(pose_to_matrix(poses)))


def _swapped(key: str, other: str) -> Change:
    """Two columns of one kind, each in the other's place."""

    def apply(root: Path) -> None:
        for path in _data_files(root):
            table = pq.read_table(path)
            names = {key: other, other: key}
            table = table.rename_columns([names.get(name, name) for name in table.column_names])
            pq.write_table(table.replace_schema_metadata(None), path)

    return apply


def cases(folder: Path, rng: np.random.Generator) -> Iterator[Case]:
    """Each fault as ``llakey check`` is given it, and each that columns or files show as a training is."""
    from lerobot_llakey import schema

    source = write_dataset(folder)
    command_reads = {schema.INSTRUCTION, schema.SAMPLE_WEIGHT, "task_index"}
    for faults, trained in ((_numbers(), True), (_texts(), True), (_metadata(), True), (_looks(), False)):
        for key, what, change in faults:
            names = (key, key.rpartition(".")[2], str(source.parent), "data")
            yield Case("dataset", f"check: {key} {what}", partial(_check, source, change), names)
            if trained:
                policy = "command" if key in command_reads else "action"
                act = partial(_train, source, change, policy)
                yield Case("dataset", f"train {policy}: {key} {what}", act, names)
