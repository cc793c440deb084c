"""Episodes in one video, each where LeRobot looks for it."""

from pathlib import Path

import av
import numpy as np
import pytest
from lerobot.configs import VideoEncoderConfig

from lerobot_llakey.datasets.demonstrations import depth_encoder, rgb_encoder
from lerobot_llakey.datasets.video_file import VideoFile

SIZE, LENGTHS = 32, (13, 1, 12)


@pytest.mark.parametrize("encoder", [rgb_encoder(), depth_encoder()], ids=["rgb", "depth"])
def test_episodes_stand_one_behind_the_other(tmp_path: Path, encoder: VideoEncoderConfig) -> None:
    is_depth = encoder.pix_fmt == "gray12le"
    rng = np.random.default_rng(0)
    levels = rng.integers(300, 4095, sum(LENGTHS)) if is_depth else rng.integers(20, 235, sum(LENGTHS))
    shape, kind = ((SIZE, SIZE, 1), np.uint16) if is_depth else ((SIZE, SIZE, 3), np.uint8)
    frames = [np.full(shape, level, kind) for level in levels]
    video = VideoFile(tmp_path / "videos" / "x.mp4", 10, encoder)
    for begin, length in zip(np.cumsum((0, *LENGTHS)), LENGTHS, strict=False):
        assert video.frames == begin
        video.add_episode(frames[begin : begin + length])
    video.close()
    with av.open(str(video.path)) as container:
        read = list(container.decode(video=0))
    assert [round(frame.time * 10) for frame in read] == list(range(sum(LENGTHS)))
    for begin in np.cumsum((0, *LENGTHS))[:-1]:
        assert read[begin].key_frame, "an episode is decoded without the others"
    form = "gray12le" if is_depth else "rgb24"
    for frame, level in zip(read, levels, strict=True):
        assert np.abs(frame.to_ndarray(format=form).astype(int) - level).max() <= (0 if is_depth else 6)
