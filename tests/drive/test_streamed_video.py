"""A video is written as it comes, and has its name only when it is whole."""

from pathlib import Path

import numpy as np

from fakes_videos import frames_of
from lerobot_llakey.drive.streamed_video import FPS, StreamedVideo


def test_frames_words_and_outcome_are_on_it(tmp_path: Path) -> None:
    path = tmp_path / "one.mp4"
    video = StreamedVideo(path)
    frame = np.full((121, 161, 3), 120, np.uint8)  # odd sides, which the codec cannot have
    for _ in range(5):
        video.add(frame, "open the drawer", "grasp the handle")
    assert not path.exists()
    assert video.finish(frame, "open the drawer", "grasp the handle", True) == path
    frames = frames_of(path)
    assert len(frames) == 5 + round(1.5 * FPS) and frames[0].shape == (120, 160, 3)
    assert [file.name for file in tmp_path.iterdir()] == ["one.mp4"]
    outcome = [picture[84:104, :80].astype(int) for picture in (frames[0], frames[-1])]
    greenish = [int((part[..., 1] - part[..., 0] > 40).sum()) for part in outcome]
    assert greenish[1] > greenish[0] + 20
