"""What a dataset says of itself: names, shapes, cameras, units, and statistics of its pictures."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.finding import Finding

_METRES = 10.0
"""Depth in millimetres exceeds this somewhere; depth in metres does not."""
_TOLD = ((schema.STATE, schema.STATE_NAMES), (schema.ACTION, schema.ACTION_NAMES))
Features = Mapping[str, Mapping[str, Any]]


def check_shapes(features: Features, reads: Collection[str]) -> Iterator[Finding]:
    """State and action have the contract's numbers, under its names where names are given."""
    for key, names in _TOLD:
        if key not in features or key not in reads:
            continue
        shape = tuple(features[key].get("shape") or ())
        if shape != (len(names),):
            advice = "record these"
            yield Finding(key, f"{len(names)} numbers ({', '.join(names)})", f"shape {shape}", advice)
            continue
        given = names_of(features[key])
        known = [name for name in given if name in names]
        misplaced = [name for place, name in enumerate(given) if name in known and names[place] != name]
        if len(given) == len(names) and misplaced:
            got = ", ".join(given)
            yield Finding(key, f"the names {', '.join(names)} in this order", got, "reorder the column and its names")


def names_of(feature: Mapping[str, Any]) -> list[str]:
    """The names of a feature's numbers, which some recorders write in groups: ``{"motors": [...]}``."""
    names = feature.get("names")
    if isinstance(names, Mapping):
        names = [name for group in names.values() for name in (group if isinstance(group, list | tuple) else [group])]
    return [] if names is None or isinstance(names, str) else [str(name) for name in names]


def cameras_of(features: Features) -> list[str]:
    """The cameras with depth, in the dataset's order; all cameras where none has."""
    front = schema.image_key("")
    names = [key.removeprefix(front) for key in features if key.startswith(front)]
    with_depth = [name for name in names if schema.depth_key(name) in features]
    return with_depth or [name for name in names if features[front + name].get("dtype") in ("image", "video")]


def sizes_of(features: Features, cameras: Sequence[str]) -> dict[str, tuple[int, int]]:
    """Height and width of the cameras' pictures."""
    shapes = {camera: tuple(features[schema.image_key(camera)]["shape"]) for camera in cameras}
    return {camera: (int(shape[0]), int(shape[1])) for camera, shape in shapes.items()}


def check_cameras(features: Features, wanted: Sequence[str] | None) -> Iterator[Finding]:
    """There is one row of calibration for each camera, in the order in which the policy takes them.

    Args:
        features: of the dataset.
        wanted: the policy's cameras, None to leave them out.
    """
    cameras = cameras_of(features)
    for key, shape in ((schema.INTRINSICS, (3, 3)), (schema.EXTRINSICS, (4, 4))):
        if key not in features:
            continue
        got = tuple(features[key].get("shape") or ())
        if got != (len(cameras), *shape):
            expected = f"one matrix of {shape[0]}x{shape[1]} for each of the cameras {', '.join(cameras)}"
            yield Finding(key, expected, f"shape {got}", "write the calibration of these cameras in this order")
    order = [camera for camera in cameras if camera in (wanted or ())]
    if wanted is not None and set(wanted) <= set(cameras) and list(wanted) != order:
        expected = f"the cameras in the policy's order, {', '.join(wanted)},"
        yield Finding(schema.EXTRINSICS, expected, ", ".join(order), "set policy.cameras in the dataset's order")


def check_pictures_notes(
    features: Features, stats: Mapping[str, Mapping[str, Any]] | None, cameras: Sequence[str], *, depth: bool
) -> Iterator[Finding]:
    """Depth is noted as depth, in millimetres, and the statistics are those of pictures with something in them.

    Args:
        features: of the dataset.
        stats: of the dataset, in the unit in which LeRobot gives depth out; None where there are none.
        cameras: to look at.
        depth: whether depth is read.
    """
    for camera in cameras:
        key, feature = schema.depth_key(camera), features.get(schema.depth_key(camera), {})
        notes = {**(feature.get("video_info") or {}), **(feature.get("info") or {})}
        if depth and feature and not (notes.get("is_depth_map") or notes.get("video.is_depth_map")):
            advice = 'set "info": {"is_depth_map": true, "depth_unit": "mm"} in meta/info.json'
            yield Finding(key, "depth that is noted as such", "no is_depth_map", advice)
        for name in [key] if depth else [schema.image_key(camera)]:
            if name not in features:
                continue
            low, high = (_extreme(stats, name, which) for which in ("min", "max"))
            if low is None or high is None or not np.isfinite((low, high)).all():
                continue
            if low == high:
                what = "depths" if name == key else "pictures"
                yield Finding(name, f"{what} that show something", f"{high:g} in every pixel", "record them anew")
            elif name == key and high < _METRES:
                advice = "set dataset.depth_output_unit=mm, or note the unit it was recorded in as depth_unit"
                yield Finding(name, "depth in millimetres", f"at most {high:.3g}: metres?", advice)


def _extreme(stats: Mapping[str, Mapping[str, Any]] | None, key: str, which: str) -> float | None:
    values = np.asarray((stats or {}).get(key, {}).get(which, ()), dtype=float)
    return None if not values.size else float(values.min() if which == "min" else values.max())
