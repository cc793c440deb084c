"""What ``llakey check`` found, as one page: counts, findings, and the first bad frame of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape
from typing import Any

import cv2
import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.finding import Finding
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading
from lerobot_llakey.reporting.html import html_page, html_picture, html_table

HEADER = ("", "column", "expected", "got", "at", "what to do")
_MOST_PICTURED = 20
_MOST_TEXTS = 60
_MOST_COUNTED = 1_000_000
"""Rows of which instructions and keyframes are counted."""


def finding_cells(finding: Finding) -> list[str]:
    """A finding as a row of a table under :data:`HEADER`."""
    kind = "refused" if finding.certain else "warning"
    return [kind, finding.column, finding.expected, finding.got, str(finding.place or "-"), finding.advice]


def check_report(dataset: Any, found: Sequence[Finding], name: str) -> str:
    """The page as HTML that needs no other file.

    Args:
        dataset: a ``LeRobotDataset``.
        found: what is wrong with it.
        name: of the dataset.
    """
    refused = sum(finding.certain for finding in found)
    parts = [f"<p>{refused} refused, {len(found) - refused} warnings</p>", _counts(dataset)]
    if found:
        parts += ["<h2>Findings</h2>", html_table(HEADER, [finding_cells(one) for one in found])]
        parts += ["<h2>The first bad frames</h2>", *(_pictured(dataset, one) for one in found[:_MOST_PICTURED])]
    return html_page(f"llakey check: {name}", parts)


def _counts(dataset: Any) -> str:
    meta = dataset.meta
    rows = [
        ["episodes", str(meta.total_episodes)],
        ["frames", f"{meta.total_frames} at {meta.fps:g} a second"],
        ["tasks", ", ".join(str(task) for task in meta.tasks.index) if meta.tasks is not None else "none"],
        ["cameras", ", ".join(_camera(meta.features, camera) for camera in schema.cameras_of(meta.features))],
    ]
    wanted = [key for key in (schema.KEYFRAME_INDEX, schema.INSTRUCTION) if key in meta.features]
    if not wanted or meta.total_frames > _MOST_COUNTED:
        return html_table(("what", "count"), rows)
    with reading(dataset.root, "dataset"):
        columns = dataset.hf_dataset.select_columns([*wanted, "episode_index"]).with_format("numpy")[:]
    if schema.KEYFRAME_INDEX in wanted:
        segments = np.stack((columns["episode_index"], columns[schema.KEYFRAME_INDEX]), axis=1)
        _, counts = np.unique(np.unique(segments, axis=0)[:, 0], return_counts=True)
        rows.append(["segments an episode", f"{counts.min()} to {counts.max()}, {counts.mean():.1f} on average"])
    table = html_table(("what", "count"), rows)
    if schema.INSTRUCTION not in wanted:
        return table
    texts = Counter(str(text) for text in columns[schema.INSTRUCTION]).most_common()
    listed = [[text, str(count)] for text, count in texts[:_MOST_TEXTS]]
    return f"{table}<h2>{len(texts)} instructions</h2>{html_table(('instruction', 'frames'), listed)}"


def _camera(features: Any, camera: str) -> str:
    height, width = features[schema.image_key(camera)]["shape"][:2]
    depth = "with depth" if schema.depth_key(camera) in features else "without depth"
    return f"{camera} ({width}x{height}, {depth})"


def _pictured(dataset: Any, finding: Finding) -> str:
    """The pictures of the first frame in which something is wrong; of the first frame of all where it is in none."""
    head = f"<h3>{escape(finding.column)}: {escape(finding.expected)}, got {escape(finding.got)}</h3>"
    try:
        row = _row(dataset, finding)
        with reading(dataset.root, "dataset"):
            item = dataset[row]
            text = f"{item.get(schema.TASK, '')}: {item.get(schema.INSTRUCTION, '')}"
            pictures = [
                html_picture(_picture(item[key]), key.removeprefix(schema.image_key("")))
                for key in _keys(dataset.features, finding)
            ]
    except LlakeyError as error:
        return f"{head}<p>{escape(str(error))}</p>"
    place = finding.place or "frame 0, as this is of all frames"
    return f"{head}<p>{escape(str(place))}; {escape(text)}</p>{''.join(pictures)}"


def _row(dataset: Any, finding: Finding) -> int:
    place = finding.place
    if place is None or place.episode is None or place.frame is None:
        return 0
    if not 0 <= place.episode < dataset.meta.total_episodes:
        return 0
    first = int(dataset.meta.episodes[place.episode]["dataset_from_index"])
    return min(max(first + place.frame, 0), len(dataset) - 1)


def _keys(features: Any, finding: Finding) -> list[str]:
    """The pictures of the camera that a finding is of; the colours of all cameras where it is of none."""
    cameras = schema.cameras_of(features)
    kinds = (schema.image_key, schema.depth_key, schema.intrinsics_key, schema.extrinsics_key)
    own = [camera for camera in cameras if finding.column in {kind(camera) for kind in kinds}]
    keys = [kind(camera) for camera in own for kind in kinds[:2]] or [schema.image_key(camera) for camera in cameras]
    return [key for key in keys if key in features]


def _picture(value: Any) -> np.ndarray:
    """Colours (3, H, W) in 0..1 as they are; depth (1, H, W) in false colours, near ones warm."""
    pixels = np.nan_to_num(np.asarray(value, dtype=np.float32)).transpose(1, 2, 0)
    if pixels.shape[-1] == 3:
        return (pixels.clip(0, 1) * 255).round().astype(np.uint8)
    depth, measured = pixels[..., 0], pixels[..., 0] > 0
    low, high = (depth[measured].min(), depth[measured].max()) if measured.any() else (0.0, 1.0)
    shade = ((high - depth) / max(high - low, 1e-6) * 255).clip(0, 255).astype(np.uint8)
    return np.where(measured[..., None], cv2.applyColorMap(shade, cv2.COLORMAP_TURBO)[..., ::-1], 0).astype(np.uint8)
