"""What only pictures tell: whether the gripper is measured where the state says that it is.

The tool's place is projected into each camera. Its fingers are then found at that pixel and at that depth, unless
something hides them. Depth of another unit, mirrored pictures and matrices that are another camera's or another way
round put something else there, in most frames.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.finding import Finding
from lerobot_llakey.checks.views import project, readings
from lerobot_llakey.geometry import pose_to_matrix
from lerobot_llakey.hand import hand_columns, names_of, read_hand

FRAMES = 16
"""Frames to look at."""
_NEAR = 0.05
"""Metres about the tool within which its fingers are."""
_FEWEST = 4
"""Frames that show the tool, below which a camera is not judged."""
_SELDOM, _OFTEN, _ALWAYS = 0.4, 0.85, 0.95
"""Shares of frames with the gripper in its place: below the first something is wrong, below the second if there is a
reading in which it is there in more than the third. It is in every frame of the simulator's cameras."""
_SMOOTH, _SMOOTH_STEP = 0.2, 0.02
"""Share of neighbouring pixels that are as near as this in metres, of any scene; noise has fewer."""
_KEYFRAME_NEAR = 0.05
_INSIDE = 0.02
_MARGIN = 0.3

Depths = np.ndarray

_DEPTH_READINGS: dict[str, Callable[[Depths], Depths]] = {
    "mirrored left to right": lambda depth: depth[..., ::-1],
    "upside down": lambda depth: depth[..., ::-1, :],
    "in centimetres": lambda depth: depth * 10,
    "in decimetres": lambda depth: depth * 100,
    "in metres": lambda depth: depth * 1000,
}
"""What depth, taken for millimetres, could be instead."""


@dataclass(frozen=True)
class Sample:
    """Frames of a dataset: N frames of C cameras.

    Attributes:
        cameras: their names.
        colours: for each camera (N, H, W, 3) in 0..1.
        depths: for each camera (N, H, W) in metres, 0 where nothing was measured.
        intrinsics: for each camera (N, 4) in pixels.
        extrinsics: for each camera (N, 4, 4) camera to base.
        hands: (N, 8).
        actions: (N, 9).
    """

    cameras: tuple[str, ...]
    colours: dict[str, np.ndarray]
    depths: dict[str, np.ndarray]
    intrinsics: dict[str, np.ndarray]
    extrinsics: dict[str, np.ndarray]
    hands: np.ndarray
    actions: np.ndarray


def pictured(cameras: Sequence[str]) -> set[str]:
    """The columns of which a sample is made."""
    kinds = (schema.image_key, schema.depth_key, schema.intrinsics_key, schema.extrinsics_key)
    return {schema.STATE, schema.ACTION, *(kind(camera) for kind in kinds for camera in cameras)}


def draw(dataset: Any, cameras: Sequence[str], count: int = FRAMES) -> Sample:
    """Decode some frames of a ``LeRobotDataset`` that gives depth in millimetres.

    Half of them are spread evenly; in the others the hand is high up, where nothing else is as near to a camera.
    """
    hand = hand_columns(names_of(dataset.features[schema.STATE]))
    height = np.asarray(dataset.hf_dataset.with_format("numpy")[schema.STATE])[:, hand[2]]
    even = np.linspace(0, len(height) - 1, max(1, count // 2)).astype(int)
    high = np.argsort(-np.nan_to_num(height), kind="stable")[: max(1, len(height) // 4)]
    rows = np.unique([*even, *high[np.linspace(0, len(high) - 1, max(1, count - len(even))).astype(int)]])
    items = [dataset[int(row)] for row in rows]

    def of(key: str) -> np.ndarray:
        return np.stack([np.asarray(item[key], dtype=np.float32) for item in items])

    colours = {camera: of(schema.image_key(camera)).transpose(0, 2, 3, 1) for camera in cameras}
    scaled = {camera: values / 255 if values.max() > 1 else values for camera, values in colours.items()}
    depths = {camera: of(schema.depth_key(camera))[:, 0] / 1000 for camera in cameras}
    intrinsics = {camera: of(schema.intrinsics_key(camera)) for camera in cameras}
    extrinsics = {camera: pose_to_matrix(of(schema.extrinsics_key(camera)).astype(float)) for camera in cameras}
    hands = read_hand(of(schema.STATE), hand)
    return Sample(tuple(cameras), scaled, depths, intrinsics, extrinsics, hands, of(schema.ACTION))


def check_pictures(sample: Sample, workspace: schema.Workspace | None = None) -> Iterator[Finding]:
    """Warn of cameras whose pictures do not fit their calibration and the robot's states.

    Args:
        sample: frames.
        workspace: bounds in metres; None for the box about all places of the hand.
    """
    clouds = []
    places = np.concatenate((sample.hands[:, schema.POSITION], sample.actions[:, schema.POSITION]))
    low, high = (places.min(axis=0), places.max(axis=0)) if workspace is None else np.array(workspace).T
    for camera in sample.cameras:
        depth, key = sample.depths[camera], schema.depth_key(camera)
        if np.ptp(sample.colours[camera]) == 0:
            got = f"{sample.colours[camera].flat[0]:g} in every pixel"
            yield Finding(schema.image_key(camera), "pictures that show something", got, "record them anew")
        if np.ptp(depth) == 0:
            got = f"{1000 * depth.flat[0]:g} mm in every pixel"
            yield Finding(key, "depths that show something", got, "record them anew")
            continue
        if 0 < depth.max() < 0.01:
            got = f"at most {1000 * depth.max():.3g}: metres?"
            yield Finding(key, "depth in millimetres", got, "note the unit it was recorded in as depth_unit")
            continue
        steps = np.abs(np.diff(depth, axis=2))[(depth[..., 1:] > 0) & (depth[..., :-1] > 0)]
        if len(steps) and (steps < _SMOOTH_STEP).mean() < _SMOOTH:
            got = f"{100 * (steps < _SMOOTH_STEP).mean():.0f} % of the pixels as far as their neighbour: noise?"
            yield Finding(key, "depths of surfaces", got, "check how depth is stored", certain=False)
        points = _lift(depth, sample.intrinsics[camera], sample.extrinsics[camera])
        inside = ((points > low - _MARGIN) & (points < high + _MARGIN)).all(axis=-1) & (depth > 0).reshape(
            len(depth), -1
        )
        clouds.append(np.where(inside[..., None], points, np.inf))
        share = inside.sum() / max((depth > 0).sum(), 1)
        if share < _INSIDE:
            got = f"{100 * share:.1f} % of its points there"
            advice = "check the depth's unit, the extrinsics and the workspace"
            yield Finding(key, f"a camera {camera} that measures the workspace", got, advice, certain=False)
        yield from _check_gripper(sample, camera)
    if clouds and len(sample.actions) >= _FEWEST:
        gaps = [
            min(np.linalg.norm(cloud[row] - target, axis=-1).min() for cloud in clouds)
            for row, target in enumerate(sample.actions[:, schema.POSITION])
        ]
        if min(gaps) > _KEYFRAME_NEAR:
            got = f"nothing within {100 * min(gaps):.0f} cm of any of {len(gaps)}"
            advice = "check depth, extrinsics and labels"
            yield Finding(schema.ACTION, "keyframes at things that the cameras measure", got, advice, certain=False)


def _check_gripper(sample: Sample, camera: str) -> Iterator[Finding]:
    found = gripper_found(sample.depths[camera], sample.intrinsics[camera], sample.extrinsics[camera], sample.hands)
    if len(found) < _FEWEST or found.mean() >= _OFTEN:
        return
    best, share = _explanation(sample, camera)
    if found.mean() >= _SELDOM and share < _ALWAYS:
        return
    got = f"it in {found.sum()} of {len(found)} frames"
    if share >= _ALWAYS:
        got += f", and in {100 * share:.0f} % if {best}"
    advice = "check this camera's depth and calibration"
    expected = f"the gripper where {schema.STATE} puts it before camera {camera}"
    yield Finding(schema.depth_key(camera), expected, got, advice, certain=False)


def _explanation(sample: Sample, camera: str) -> tuple[str, float]:
    """The reading in which the gripper is in its place most often, and how often."""
    depth, intrinsics, extrinsics = sample.depths[camera], sample.intrinsics[camera], sample.extrinsics[camera]
    tried: dict[str, np.ndarray] = {}
    for name, change in _DEPTH_READINGS.items():
        tried[f"its depth is {name}"] = gripper_found(change(depth), intrinsics, extrinsics, sample.hands)
    for name, matrices in readings(extrinsics.astype(float)).items():
        tried[f"its extrinsics are {name}"] = gripper_found(depth, intrinsics, matrices, sample.hands)
    halved = intrinsics.copy()
    halved[:, :2] /= 2
    tried["its focal length is half of that"] = gripper_found(depth, halved, extrinsics, sample.hands)
    # Something is as near to a camera on the hand in any picture: that it is this one explains nothing.
    for other in sample.cameras:
        matrices = sample.extrinsics[other]
        if other != camera and np.ptp(matrices, axis=0).max() < _NEAR:
            tried[f"it stands where camera {other} does"] = gripper_found(depth, intrinsics, matrices, sample.hands)
    shares = {name: hits.mean() for name, hits in tried.items() if len(hits) >= _FEWEST}
    best = max(shares, key=lambda name: shares[name], default="")
    return best, float(shares.get(best, 0.0))


def gripper_found(depth: np.ndarray, intrinsics: np.ndarray, extrinsics: np.ndarray, hands: np.ndarray) -> np.ndarray:
    """For each frame that has the tool in its picture, whether something is measured there.

    Args:
        depth: (N, H, W) metres.
        intrinsics: (N, 4) in pixels.
        extrinsics: (N, 4, 4) camera to base.
        hands: (N, 8).

    Returns:
        (F,) bool for the F frames that should show the tool.
    """
    pixels, far = project(extrinsics.astype(float), intrinsics.astype(float), hands[:, schema.POSITION].astype(float))
    height, width = depth.shape[1:]
    shown = (far > _NEAR) & (pixels >= 0).all(axis=1) & (pixels < (width, height)).all(axis=1)
    found = []
    for row in np.flatnonzero(shown):
        reach = max(1.0, float(intrinsics[row, 0]) * _NEAR / far[row])
        (left, top), (right, bottom) = (
            np.floor(pixels[row] - reach).astype(int),
            np.ceil(pixels[row] + reach).astype(int),
        )
        patch = depth[row, max(top, 0) : bottom + 1, max(left, 0) : right + 1]
        found.append(bool((np.abs(patch[patch > 0] - far[row]) < _NEAR).any()))
    return np.array(found, dtype=bool)


def _lift(depth: np.ndarray, intrinsics: np.ndarray, extrinsics: np.ndarray) -> np.ndarray:
    """Depths (N, H, W) as points (N, H * W, 3) of the base frame."""
    height, width = depth.shape[1:]
    v, u = np.meshgrid(np.arange(height) + 0.5, np.arange(width) + 0.5, indexing="ij")
    focal_x, focal_y, centre_x, centre_y = intrinsics.T[:, :, None, None]
    local = np.stack(((u - centre_x) / focal_x * depth, (v - centre_y) / focal_y * depth, depth), axis=-1)
    local = local.reshape(len(depth), -1, 3)
    return np.einsum("nij,npj->npi", extrinsics[:, :3, :3], local) + extrinsics[:, None, :3, 3]
