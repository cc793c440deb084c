"""A video shows the words and the outcome, and is there as a whole or not at all."""

from pathlib import Path

import av
import numpy as np

from lerobot_llakey.rollout.actors import Expert
from lerobot_llakey.rollout.episode import run_episode
from lerobot_llakey.rollout.video import EpisodeVideo
from lerobot_llakey.sim.env import LlakeySimEnv


def _frames(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as file:
        return [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]


def test_an_episode_is_filmed_with_its_outcome(tmp_path: Path) -> None:
    env = LlakeySimEnv("open_drawer", image_size=32, render_size=(120, 160), episode_length=1)
    video = EpisodeVideo()
    run_episode(env, Expert(), 0, [video])
    video.save(tmp_path / "videos" / "one.mp4")
    frames = _frames(tmp_path / "videos" / "one.mp4")
    assert [path.name for path in (tmp_path / "videos").iterdir()] == ["one.mp4"]
    assert len(frames) > 25
    # The outcome stands in red above the lower band, on the last frames alone.
    outcome = [frame[84:104, :80].astype(int) for frame in (frames[0], frames[-1])]
    reddish = [int(((part[..., 0] - part[..., 1] > 60) & (part[..., 0] > 150)).sum()) for part in outcome]
    assert reddish[1] > reddish[0] + 20
    env.close()


def test_nothing_is_recorded_after_the_end(tmp_path: Path) -> None:
    env = LlakeySimEnv("open_drawer", image_size=32, render_size=(120, 160), episode_length=1)
    video = EpisodeVideo()
    run_episode(env, Expert(), 0, [video])
    video.save(tmp_path / "one.mp4")
    video.save(tmp_path / "two.mp4")
    run_episode(env, Expert(), 1)
    video.save(tmp_path / "three.mp4")
    assert len(_frames(tmp_path / "three.mp4")) == len(_frames(tmp_path / "two.mp4"))
    env.close()
