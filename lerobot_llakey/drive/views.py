"""The pictures of a moment as one picture."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.drive.driven_episode import VIEWER


def one_picture(pictures: Mapping[str, np.ndarray]) -> np.ndarray:
    """The human's picture with the policy's views in a row below it.

    Args:
        pictures: camera name, or "viewer" -> (h, w, 3) uint8.

    Returns:
        (H, W, 3) uint8, as wide as the human's picture.
    """
    viewer = pictures[VIEWER]
    side = viewer.shape[1] // len(schema.CAMERAS)
    row = np.zeros((side, viewer.shape[1], 3), np.uint8)
    for place, camera in enumerate(schema.CAMERAS):
        view = np.ascontiguousarray(pictures[camera])
        row[:, place * side : (place + 1) * side] = cv2.resize(view, (side, side), interpolation=cv2.INTER_AREA)
    return np.concatenate((viewer, row))


def jpeg(picture: np.ndarray, quality: int = 85) -> bytes:
    """A picture (H, W, 3) uint8 RGB as the bytes of a JPEG file."""
    return cv2.imencode(".jpg", picture[..., ::-1], (cv2.IMWRITE_JPEG_QUALITY, quality))[1].tobytes()
