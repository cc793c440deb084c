"""The video of an episode, written while it goes on: a person may drive for as long as they like."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from lerobot_llakey.rollout.captions import annotate_frame

FPS = 10
_HOLD_SECONDS = 1.5


class StreamedVideo:
    """Encodes frames as they come, with the goal and the instruction on them.

    The file has a name with a leading dot until it is whole.

    Args:
        path: an mp4 file in a folder that exists.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._unfinished = path.with_name(f".{path.name}")
        self._container: av.container.OutputContainer | None = None
        self._stream: av.VideoStream | None = None

    def add(self, frame: np.ndarray, goal: str, instruction: str, outcome: bool | None = None) -> None:
        """Add one frame (H, W, 3) uint8 with the words on it; ``outcome`` as in :func:`annotate_frame`."""
        if self._container is None or self._stream is None:
            self._container = av.open(str(self._unfinished), mode="w", format="mp4")
            options = {"preset": "veryfast", "threads": "1"}
            self._stream = self._container.add_stream("libx264", rate=Fraction(FPS), options=options)
            # libx264's 4:2:0 needs even numbers.
            self._stream.height, self._stream.width = (side - side % 2 for side in frame.shape[:2])
            self._stream.pix_fmt = "yuv420p"
        picture = annotate_frame(frame, goal, instruction, outcome)[: self._stream.height, : self._stream.width]
        encoded = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
        self._container.mux(self._stream.encode(encoded))

    def finish(self, frame: np.ndarray, goal: str, instruction: str, outcome: bool) -> Path:
        """Hold a last frame with the outcome for a moment and give the file its name.

        Returns:
            Where the video is.
        """
        for _ in range(round(_HOLD_SECONDS * FPS)):
            self.add(frame, goal, instruction, outcome)
        assert self._container is not None and self._stream is not None
        self._container.mux(self._stream.encode())
        self._container.close()
        return self._unfinished.replace(self.path)
