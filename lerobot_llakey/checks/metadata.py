"""What a dataset says of itself: names, shapes, cameras, units, and statistics of its pictures."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.finding import Finding
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.hand import hand_columns, names_of

_METRES = 10.0
"""Depth in millimetres exceeds this somewhere; depth in metres does not."""
Features = Mapping[str, Mapping[str, Any]]
Size = tuple[int, int]


def check_shapes(features: Features, reads: Collection[str]) -> Iterator[Finding]:
    """The state's names tell the hand; the action has the contract's numbers, under its names where some are given."""
    if schema.STATE in features and schema.STATE in reads:
        key, count = schema.STATE, int(np.prod(tuple(features[schema.STATE].get("shape") or (0,))))
        names = names_of(features[key])
        if len(names) != count:
            yield Finding(key, f"a name for each of {count} numbers", f"{len(names)}", "name them with llakey annotate")
        else:
            try:
                hand_columns(names)
            except LlakeyError:
                got, advice = ", ".join(names), "name them, or convert them with llakey annotate"
                yield Finding(key, f"the hand's {', '.join(schema.POSE_NAMES)} among the names, once each", got, advice)
    if schema.ACTION in features and schema.ACTION in reads:
        key, wanted = schema.ACTION, schema.ACTION_NAMES
        shape = tuple(features[key].get("shape") or ())
        if shape != (len(wanted),):
            expected, advice = (
                f"{len(wanted)} numbers ({', '.join(wanted)})",
                "label the recordings with llakey annotate",
            )
            yield Finding(key, expected, f"shape {shape}", advice)
        elif (given := names_of(features[key])) != list(wanted) and len(given) == len(wanted):
            expected, advice = f"the names {', '.join(wanted)} in this order", "reorder the column and its names"
            yield Finding(key, expected, ", ".join(given), advice)


def sizes_of(features: Features, cameras: Sequence[str]) -> dict[str, Size]:
    """Height and width of the cameras' pictures, of those that the features hold."""
    shapes = {camera: features[schema.image_key(camera)]["shape"] for camera in cameras
              if schema.image_key(camera) in features}  # fmt: skip
    return {camera: (int(shape[0]), int(shape[1])) for camera, shape in shapes.items()}


def check_cameras(features: Features, cameras: Sequence[str]) -> Iterator[Finding]:
    """Depth and colour of a camera have one size, and its calibration has the contract's numbers.

    Args:
        features: of the dataset.
        cameras: whose depth is read.
    """
    for camera in cameras:
        for key, names in (
            (schema.intrinsics_key(camera), schema.INTRINSICS_NAMES),
            (schema.extrinsics_key(camera), schema.POSE_NAMES),
        ):
            expected, feature = f"{len(names)} numbers ({', '.join(names)})", features.get(key, {})
            shape, given = tuple(feature.get("shape") or ()), names_of(feature)
            if shape != (len(names),):
                got = f"shape {shape}" if feature else "no such column"
                yield Finding(key, expected, got, "write them with llakey annotate --calibration")
            elif len(given) == len(names) and given != list(names):
                yield Finding(key, f"{expected} in this order", ", ".join(given), "reorder the column and its names")
        image, depth = schema.image_key(camera), schema.depth_key(camera)
        if image in features and depth in features:
            sizes = [tuple(features[key]["shape"])[:2] for key in (image, depth)]
            if sizes[0] != sizes[1]:
                expected = f"depth of the size of the colours, {sizes[0][1]}x{sizes[0][0]} pixels,"
                got = f"{sizes[1][1]}x{sizes[1][0]}"
                yield Finding(depth, expected, got, "record depth that is aligned with the colours")


def check_uncalibrated(features: Features) -> Iterator[Finding]:
    """A camera with depth but without calibration serves the command policy only: it may have been forgotten."""
    usable = schema.cameras_of(features, depth=True)
    for camera in schema.cameras_of(features):
        if schema.depth_key(camera) in features and camera not in usable:
            lacking = [
                key for key in (schema.intrinsics_key(camera), schema.extrinsics_key(camera)) if key not in features
            ]
            got = f"no {' and no '.join(lacking)}"
            advice = "add it with llakey annotate --calibration, if its depth is to be used"
            yield Finding(schema.depth_key(camera), "depth with a calibration", got, advice, certain=False)


def check_pictures_notes(
    features: Features, stats: Mapping[str, Mapping[str, Any]] | None, cameras: Collection[str], *, depth: bool
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
