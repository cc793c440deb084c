"""One page about one decision: cameras, virtual views with heatmaps, and the predicted and true poses in 3D."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.inspection.oblique_view import ObliqueView
from lerobot_llakey.inspection.trace import StageTrace, Trace
from lerobot_llakey.policies.action.views.renderer import VIEWS

PREDICTED, TRUE = (255, 150, 30), (60, 220, 90)
"""RGB of what the policy decided and of what was recorded, on the page and in rerun."""
_TILE, _PANEL = 240, 420
"""Height in pixels of pictures and of the 3D panels."""
_WIDEST = 1200
"""Pixels of a row of cameras."""
_LINE, _FONT, _WHITE = 28, cv2.FONT_HERSHEY_SIMPLEX, (235, 235, 235)
_NEAR = 0.35
"""Metres along the height of the 3D panel that shows the poses from near."""


def page(trace: Trace) -> np.ndarray:
    """Draw the page.

    Returns:
        (rows, columns, 3) uint8 RGB: the words, rows of cameras, a row of virtual views for each stage (as the
        network sees them, only upright), and the cloud with both hands, whole and from near.
    """
    rows = _rows([_camera(name, image) for name, image in trace.cameras.items()])
    rows += [_stage(stage, trace) for stage in trace.stages]
    width = max(row.shape[1] for row in rows)
    rows += [_panels(trace, width)]
    padded = [np.pad(row, ((0, 4), (0, width - row.shape[1]), (0, 0))) for row in rows]
    return np.concatenate([_words(trace, width), *padded])


def report(trace: Trace) -> list[str]:
    """The words of the page: what is asked for, and how far off the answer is."""
    errors = trace.errors()
    gripper = ["closed", "open"]
    predicted, true = (gripper[int(action[schema.GRIPPER] > 0.5)] for action in (trace.predicted, trace.true))
    flag = "right" if errors["collision"] else "wrong"
    said = [f"command policy: {trace.said}"] if trace.said else []
    return [
        f"task: {trace.task}",
        f"instruction: {trace.instruction or '(none)'}",
        *said,
        f"off by {errors['centimetres']:.1f} cm and {errors['degrees']:.1f} degrees; "
        f"gripper {'right' if errors['gripper'] else 'wrong'} ({predicted}, recorded {true}); collision flag {flag}",
    ]


def heatmap_over(image: np.ndarray, heatmap: np.ndarray) -> np.ndarray:
    """A heatmap (S, S), any positive scale, over an image (S, S, 3) in 0..1: uint8, opaque where it is hottest."""
    share = (heatmap / max(float(heatmap.max()), 1e-12)) ** 0.4  # small shares would hardly show
    warm = cv2.applyColorMap((share * 255).astype(np.uint8), cv2.COLORMAP_HOT)[..., ::-1]
    cover = share[..., None]
    return ((1 - cover) * np.clip(image, 0, 1) * 255 + cover * warm).astype(np.uint8)


def _camera(name: str, image: Tensor) -> np.ndarray:
    pixels = (image.clamp(0, 1) * 255).byte().numpy()
    width = max(round(_TILE * pixels.shape[1] / pixels.shape[0]), 1)
    return _titled(cv2.resize(pixels, (width, _TILE), interpolation=cv2.INTER_NEAREST), name.replace("_", " "))


def _rows(tiles: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Tiles of one height side by side, in a new row where one would get too wide."""
    rows: list[list[np.ndarray]] = [[]]
    for tile in tiles:
        if rows[-1] and sum(other.shape[1] for other in rows[-1]) + tile.shape[1] > _WIDEST:
            rows.append([])
        rows[-1].append(tile)
    return [np.concatenate(row, axis=1) for row in rows]


def _stage(stage: StageTrace, trace: Trace) -> np.ndarray:
    tiles = []
    for view, name in enumerate(stage.views):
        tile = heatmap_over(stage.images[view].numpy(), stage.heatmap[view].numpy())
        tile = cv2.resize(tile, (_TILE, _TILE), interpolation=cv2.INTER_NEAREST)
        upright = VIEWS[name][0] != 2
        tile = np.ascontiguousarray(tile if upright else tile[::-1])
        for action, colour in ((trace.true, TRUE), (trace.predicted, PREDICTED)):
            row, column = (float(stage.local(action[schema.POSITION])[axis]) for axis in VIEWS[name][:2])
            spot = (round(column * _TILE), round((row if upright else 1 - row) * _TILE))
            cv2.drawMarker(tile, spot, colour, cv2.MARKER_CROSS if colour == TRUE else cv2.MARKER_SQUARE, 14, 1)
        tiles.append(_titled(tile, f"{stage.name}: {name}"))
    return np.concatenate(tiles, axis=1)


def _panels(trace: Trace, width: int) -> np.ndarray:
    points, colours = trace.points.numpy(), trace.colours.numpy()
    whole = (points.min(axis=0) + points.max(axis=0)) / 2
    poses = [action.numpy() for action in (trace.true, trace.predicted)]
    between = np.mean([pose[schema.POSITION] for pose in poses], axis=0)
    apart = float(np.linalg.norm(poses[0][schema.POSITION] - poses[1][schema.POSITION]))
    panels = []
    for name, centre, span, size, half in (
        ("cloud", whole, 1.1, 2, width // 2),
        ("from near", between, max(_NEAR, 1.6 * apart), 5, width - width // 2),
    ):
        view = ObliqueView(centre, span, half, _PANEL)
        panel = view.draw_cloud(points, colours, size)
        # The recorded hand is drawn wide, so that it still shows behind a prediction that is right.
        for pose, colour, pen in zip(poses, (TRUE, PREDICTED), (6, 2), strict=True):
            view.draw_gripper(panel, pose, colour, pen)
        panels.append(_titled(panel, name))
    return np.concatenate(panels, axis=1)


def _words(trace: Trace, width: int) -> np.ndarray:
    lines = [(line, _WHITE) for line in report(trace)]
    strip = np.zeros((_LINE * (len(lines) + 1) + 8, width, 3), dtype=np.uint8)
    for number, (line, colour) in enumerate(lines):
        _write(strip, line, (10, _LINE * (number + 1) - 6), colour, width - 20)
    bottom = _LINE * (len(lines) + 1) - 6
    _write(strip, "predicted (square)", (10, bottom), PREDICTED, width)
    _write(strip, "recorded (cross)", (200, bottom), TRUE, width)
    return strip


def _titled(picture: np.ndarray, title: str) -> np.ndarray:
    picture = np.ascontiguousarray(picture)
    for colour, thickness in (((0, 0, 0), 3), (_WHITE, 1)):
        cv2.putText(picture, title, (6, 16), _FONT, 0.45, colour, thickness, cv2.LINE_AA)
    return picture


def _write(strip: np.ndarray, text: str, origin: tuple[int, int], colour: tuple[int, int, int], room: int) -> None:
    """One line of text, shrunk where it is longer than the room."""
    (length, _), _ = cv2.getTextSize(text, _FONT, 0.55, 1)
    cv2.putText(strip, text, origin, _FONT, 0.55 * min(1.0, room / max(length, 1)), colour, 1, cv2.LINE_AA)
