"""What the rules look at: how one episode's hand and gripper moved, smoothed against noise and tremor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import savgol_filter

from lerobot_llakey.bounds import require_number
from lerobot_llakey.errors import LlakeyError


@dataclass(frozen=True)
class Motion:
    """One episode.

    Attributes:
        poses: (T, 7) the hand's, metres and quaternions xyzw without jumps of sign.
        openings: (T,) of the gripper, 0 closed to 1 open; a constant without a gripper.
        fps: frames a second.
        joints: (T, J) radians, None where none were recorded.
        commanded: (T,) bool, whether the gripper was told to be open, None where no command was recorded.
    """

    poses: np.ndarray
    openings: np.ndarray
    fps: float
    joints: np.ndarray | None = None
    commanded: np.ndarray | None = None

    def __post_init__(self) -> None:
        length = len(self.openings)
        if length < 2 or self.openings.ndim != 1 or self.poses.shape != (length, 7):
            raise LlakeyError(
                f"Expected poses (T, 7) and gripper openings (T,) with T >= 2, got {self.poses.shape} and "
                f"{self.openings.shape}; pass one whole episode."
            )
        if not (np.isfinite(self.poses).all() and np.isfinite(self.openings).all()):
            raise LlakeyError("Expected finite poses and gripper openings, got NaN or inf; drop the episode.")
        require_number("fps", self.fps, 0, open="low")

    def __len__(self) -> int:
        return len(self.openings)


def smoothed(values: np.ndarray, fps: float, seconds: float) -> np.ndarray:
    """Numbers (T, N) without spikes and with less noise: a median of three, then Savitzky and Golay's parabolas.

    Args:
        values: one row a frame.
        fps: frames a second.
        seconds: width of the parabolas, at least five frames.
    """
    calm = median_filter(values, size=(3, 1), mode="nearest")
    width = max(5, 2 * round(seconds * fps / 2) + 1)
    if len(calm) <= width:
        return calm
    return np.asarray(savgol_filter(calm, width, 2, axis=0, mode="interp"))
