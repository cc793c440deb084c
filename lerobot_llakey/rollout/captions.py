"""What a person reads on a video: the skill instruction, the current basic instruction, and how it ended."""

from __future__ import annotations

import cv2
import numpy as np

_FONT = cv2.FONT_HERSHEY_SIMPLEX
_WHITE, _AMBER, _GREEN, _RED = (255, 255, 255), (255, 200, 60), (90, 220, 90), (240, 90, 80)
_BAND = 0.13
"""Share of the picture's height that each of the two dark bands takes."""


def annotate_frame(frame: np.ndarray, task: str, instruction: str, outcome: bool | None = None) -> np.ndarray:
    """Write the words on a copy of a frame.

    Args:
        frame: (H, W, 3) uint8 RGB.
        task: skill instruction, shown above.
        instruction: current basic instruction, shown below.
        outcome: success or failure once the episode is over.

    Returns:
        (H, W, 3) uint8 RGB.
    """
    frame = frame.copy()
    height = frame.shape[0]
    band = round(_BAND * height)
    for rows in (slice(0, band), slice(height - band, height)):
        frame[rows] = frame[rows] // 3
    _write(frame, task, band, _WHITE)
    _write(frame, instruction, height, _AMBER)
    if outcome is not None:
        _write(frame, "done" if outcome else "not done", height - band, _GREEN if outcome else _RED)
    return frame


def _write(frame: np.ndarray, text: str, bottom: int, colour: tuple[int, int, int]) -> None:
    """One line of text, shrunk to the frame's width, that ends just above row ``bottom``."""
    width = frame.shape[1]
    scale, thickness = width / 800, max(1, width // 400)
    (length, line), _ = cv2.getTextSize(text, _FONT, scale, thickness)
    scale *= min(1.0, 0.94 * width / max(length, 1))
    band = round(_BAND * frame.shape[0])
    origin = (round(0.03 * width), bottom - (band - line) // 2)
    cv2.putText(frame, text, origin, _FONT, scale, colour, thickness, cv2.LINE_AA)
