"""Datasets whose files went bad on the way: flipped bits, files cut, zeroed, swapped or gone, numbers that are none.

Each is opened and checked as ``lerobot-train`` does before its first step. What passes must be the same data to the
last bit, decoded; else it would be trained on in silence.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.case import Case
from fuzz.datasets_on_disk import _array, _column, _pictures

Change = Callable[[Path], None]
FILES = ("data/**/*.parquet", "videos/**/*.mp4", "meta/episodes/**/*.parquet", "meta/tasks.parquet", "meta/info.json",
         "meta/stats.json")  # fmt: skip
COUNT = 200


def _open_and_check(source: Path, change: Change, folder: Path) -> str | None:
    from lerobot_llakey.checks.dataset import check_dataset, needs_all
    from lerobot_llakey.datasets.opening import open_dataset

    root = folder / "data"
    shutil.copytree(source, root)
    change(root)
    dataset = open_dataset("fuzz/data", root)
    check_dataset(dataset.meta, needs_all(dataset.features))
    return "right" if _same(_content(source), _content(root)) else None


@cache
def _content(root: Path) -> list[dict[str, Any]]:
    """All that a training reads: every frame, decoded, and what the dataset says of itself."""
    from lerobot_llakey.datasets.opening import open_dataset

    dataset = open_dataset("fuzz/data", root)
    told = {"features": dict(dataset.features), "stats": dataset.meta.stats, "fps": dataset.fps}
    return [told, *(dataset[index] for index in range(len(dataset)))]


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    return bool(np.array_equal(np.asarray(one), np.asarray(other)))


def _spoilt(name: str, spoil: Callable[[bytearray], Any]) -> Change:
    def change(root: Path) -> None:
        path = root / name
        content = bytearray(path.read_bytes())
        changed = spoil(content)
        path.write_bytes(content if changed is None else changed)

    return change


def _bytes(rng: np.random.Generator, name: str, size: int) -> tuple[str, Change]:
    """One way in which a file's bytes go bad."""
    place, length = int(rng.integers(size)), int(rng.integers(1, 4097))
    kind = rng.choice(["bit", "bit", "bit", "burst", "zeros", "cut", "longer"])
    if kind == "bit":
        bit = 1 << int(rng.integers(8))
        return f"{name}: bit {bit} of byte {place}", _spoilt(name, lambda c: c.__setitem__(place, c[place] ^ bit))
    if kind == "burst":
        noise = np.random.default_rng(place)
        return f"{name}: {length} random bytes from {place}", _spoilt(
            name, lambda c: bytes(c[:place]) + noise.bytes(len(c[place : place + length])) + bytes(c[place + length :])
        )
    if kind == "zeros":
        return f"{name}: {length} zeros from {place}", _spoilt(
            name, lambda c: bytes(c[:place]) + bytes(len(c[place : place + length])) + bytes(c[place + length :])
        )
    if kind == "cut":
        return f"{name}: cut to {place} bytes", _spoilt(name, lambda c: bytes(c[:place]))
    return f"{name}: {length} bytes longer", _spoilt(name, lambda c: bytes(c) + bytes([7]) * length)


def _values(rng: np.random.Generator) -> tuple[str, Change]:
    """Numbers, texts and pictures that are none, and columns of another shape."""
    from lerobot_llakey import schema

    camera = str(rng.choice(schema.CAMERAS))
    keys = [schema.STATE, schema.ACTION, schema.intrinsics_key(camera), schema.extrinsics_key(camera)]
    key, row, number = str(rng.choice(keys)), int(rng.integers(8)), int(rng.integers(4))
    value = float(rng.choice([math.nan, math.inf, -math.inf, 1e30, -1e6]))
    kind = rng.choice(["number", "number", "shape", "text", "order", "black"])
    if kind == "number":
        return f"{key}[{row}, {number}] = {value}", _one_number(key, row, number, value)
    if kind == "shape":
        return f"{key} of {number} numbers", _reshaped(key, number)
    if kind == "text":
        text = str(rng.choice(["", "asdf qwer", "grasp <image>", "x" * 999]))
        return f"instruction {row} = {text[:20]!r}", _one_text(schema.INSTRUCTION, row, text)
    if kind == "order":
        column = str(rng.choice(["frame_index", "index", "timestamp", schema.NEXT_KEYFRAME, schema.KEYFRAME_INDEX]))
        return f"{column} turned round", _column(column, lambda values: values[::-1])
    return f"{camera} of one colour", _one_colour(schema.image_key(camera))


def _one_colour(key: str) -> Change:
    def change(root: Path) -> None:
        import json

        _pictures(key, lambda pixels: pixels * 0)(root)
        stats = json.loads((root / "meta/stats.json").read_text())
        stats[key] = {name: (np.zeros_like(value) if name != "count" else np.array(value)).tolist()
                      for name, value in stats[key].items()}  # fmt: skip
        (root / "meta/stats.json").write_text(json.dumps(stats))

    return change


def _one_number(key: str, row: int, place: int, value: float) -> Change:
    return _array(key, lambda array: array.__setitem__((row % len(array), place), value))


def _one_text(key: str, row: int, text: str) -> Change:
    return _column(key, lambda old: [text if place == row % len(old) else one for place, one in enumerate(old)])


def _reshaped(key: str, width: int) -> Change:
    def change(root: Path) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        for path in sorted((root / "data").rglob("*.parquet")):
            table = pq.read_table(path)
            rows = pa.array([row[:width] for row in table[key].to_pylist()], type=pa.list_(pa.float32()))
            table = table.set_column(table.column_names.index(key), key, rows)
            pq.write_table(table.replace_schema_metadata(None), path)

    return change


def _gone(name: str) -> tuple[str, Change]:
    return f"{name}: gone", lambda root: (root / name).unlink()


def cases(folder: Path, rng: np.random.Generator, noted: bool = True) -> Iterator[Case]:
    """So many files of both kinds of datasets that went bad, and values that no checksum was noted of.

    Args:
        folder: where the datasets are made.
        rng: of the draw.
        noted: whether the datasets hold checksums of their files.
    """
    from lerobot_llakey.checks.checksums import CHECKSUMS
    from lerobot_llakey.datasets.collect import collect
    from lerobot_llakey.datasets.plan import CollectSettings, Targets

    sources = {"demonstrations": folder / "demonstrations", "keysteps": folder / "keysteps"}
    targets = Targets(sources["demonstrations"], sources["keysteps"], "fuzz/data", "fuzz/data")
    collect(CollectSettings(("open_drawer",), num_episodes=1, image_size=64), targets, num_workers=1,
            progress=lambda *_: None)  # fmt: skip
    bare = folder / "bare"
    shutil.copytree(sources["keysteps"], bare)
    (bare / CHECKSUMS).unlink()
    for source in sources.values():
        if not noted:
            (source / CHECKSUMS).unlink()
    seen: set[str] = set()
    while len(seen) < COUNT:
        kind, source = list(sources.items())[int(rng.integers(2))]
        if noted and rng.random() < 0.3:
            kind, source, (what, change) = "values", bare, _values(rng)
        else:
            paths = [path for pattern in [str(rng.choice(FILES))] for path in sorted(source.glob(pattern))]
            if not paths:
                continue
            path = paths[int(rng.integers(len(paths)))]
            name = str(path.relative_to(source))
            what, change = _gone(name) if rng.random() < 0.1 else _bytes(rng, name, path.stat().st_size)
        if f"{kind} {what}" not in seen:
            seen.add(f"{kind} {what}")
            group = "corrupted" if noted else "corrupted, no checksums"
            yield Case(group, f"{kind}: {what}", partial(_open_and_check, source, change))
