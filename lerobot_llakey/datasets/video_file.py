"""One stream of a dataset's videos: the episodes one behind the other in one file, as LeRobot reads them."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from lerobot.configs import DepthEncoderConfig, VideoEncoderConfig
from lerobot.datasets.depth_utils import quantize_depth

_TICKS = 1024
"""Parts of a frame in which a file's times are counted."""


class VideoFile:
    """A video that grows by episodes, each of which can be decoded without the others.

    LeRobot's writer makes a file of each episode and copies all that came before behind which it goes. Here each
    episode gets an encoder of its own, as there, and its packets go into the one file.

    Args:
        path: of the file.
        fps: frames a second.
        encoder: how frames are encoded.
    """

    def __init__(self, path: Path, fps: int, encoder: VideoEncoderConfig) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self.path, self.frames = path, 0
        self._decoded = -_TICKS * 1000
        self._fps, self._encoder = fps, encoder
        self._container = av.open(str(path), "w")
        self._stream: av.VideoStream | None = None

    def add_episode(self, frames: Sequence[np.ndarray]) -> None:
        """Append an episode of RGB uint8 (H, W, 3) or depth uint16 (H, W, 1) frames in millimetres."""
        height, width = frames[0].shape[:2]
        codec: av.VideoCodecContext
        if self._stream is None:
            self._stream = self._container.add_stream(self._encoder.vcodec, self._fps, options=self._options())
            codec = self._stream.codec_context
        else:
            codec = av.CodecContext.create(self._encoder.vcodec, "w")
            codec.options = self._options()
            codec.framerate = Fraction(self._fps)
            codec.flags = self._stream.codec_context.flags  # headers go into the file's, not into the packets
        codec.pix_fmt, codec.width, codec.height = self._encoder.pix_fmt, width, height
        codec.time_base = Fraction(1, self._fps)
        for number, frame in enumerate(frames):
            picture = self._picture(frame)
            picture.pts, picture.time_base = number, codec.time_base
            self._mux(codec, picture)
        self._mux(codec, None)
        self.frames += len(frames)

    def _options(self) -> dict[str, str]:
        options: dict[str, str] = self._encoder.get_codec_options(1, as_strings=True)
        return options

    def _picture(self, frame: np.ndarray) -> av.VideoFrame:
        encoder = self._encoder
        if isinstance(encoder, DepthEncoderConfig):
            ranges = encoder.depth_min, encoder.depth_max, encoder.shift, encoder.use_log
            return quantize_depth(frame, *ranges, pix_fmt=encoder.pix_fmt, video_backend=encoder.video_backend)
        return av.VideoFrame.from_ndarray(frame, format="rgb24")

    def _mux(self, codec: av.VideoCodecContext, picture: av.VideoFrame | None) -> None:
        for packet in codec.encode(picture):
            if packet.pts is not None and packet.dts is not None:
                # An episode is to be decoded a little ahead of its first frame, but behind the one before.
                self._decoded = max((packet.dts + self.frames) * _TICKS, self._decoded + 1)
                packet.pts, packet.dts = (packet.pts + self.frames) * _TICKS, self._decoded
            packet.duration, packet.time_base = _TICKS, Fraction(1, self._fps * _TICKS)
            assert self._stream is not None
            packet.stream = self._stream
            self._container.mux(packet)

    def close(self) -> None:
        """Finish the file; without it the video cannot be read."""
        self._container.close()
