"""Episodes in one video, each where LeRobot looks for it."""

from pathlib import Path

import av
import numpy as np
import pytest
from lerobot.configs import VideoEncoderConfig

from lerobot_llakey.datasets.demonstrations import depth_encoder, rgb_encoder
from lerobot_llakey.datasets.video_file import VideoFile

SIZE, LENGTHS = 32, (13, 1, 12)


@pytest.mark.parametrize("encoder", [rgb_encoder(), depth_encoder((SIZE, SIZE))], ids=["rgb", "depth"])
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


@pytest.mark.parametrize("size", [16, 32, 48, 64])
def test_depth_of_any_size_is_exact(tmp_path: Path, size: int) -> None:
    # Edges that move over a slope: where x265 went wrong in pictures of 32 pixels.
    rng, (rows, columns) = np.random.default_rng(0), np.indices((size, size))
    frames = []
    for index in range(60):
        depth = 900 + 7 * rows + 3 * columns + 40 * np.sin(columns / 3 + index / 5)
        edge = size // 4 + index % (size // 2)
        depth[edge:, : edge // 2] -= 300
        depth[:, edge] += 500
        frames.append((depth + rng.normal(0, 2, depth.shape)).astype(np.uint16)[..., None])
    video = VideoFile(tmp_path / "x.mp4", 10, depth_encoder((size, size)))
    video.add_episode(frames)
    video.close()
    with av.open(str(video.path)) as container:
        read = np.stack([frame.to_ndarray(format="gray12le") for frame in container.decode(video=0)])
    assert np.array_equal(read, np.stack(frames)[..., 0])
