"""A ride keeps each episode's records in a folder of their own."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from lerobot_llakey.drive.driven_episode import DrivenEpisode
from lerobot_llakey.drive.pilot import ROW, Pilot
from lerobot_llakey.sim.env import LlakeySimEnv


def test_episodes_follow_one_another(pilot: Pilot, make_env: Callable[[str], LlakeySimEnv], tmp_path: Path) -> None:
    frames: list[np.ndarray] = []
    ride = DrivenEpisode(pilot, make_env, tmp_path, frames.append)
    assert ride.end() is None
    ride.begin("open_drawer", 3)
    first = ride.folder
    assert ride.goal == ride.own_goal and not ride.success and frames == []
    pilot.corrections.change_task(ROW, "tidy up")
    assert ride.goal == "tidy up" != ride.own_goal
    before = ride.pictures["viewer"]
    ride.propose()
    step = ride.step()
    assert not step.own_goal and step.step.task == "tidy up"
    assert len(frames) > 5 and frames[0].shape == before.shape and (ride.pictures["viewer"] != before).any()
    ride.begin("open_drawer", 3)
    assert (first / "video.mp4").exists() and ride.folder == tmp_path / "open_drawer_003_2"
    assert ride.goal == ride.own_goal
    ride.close()
    assert len((first / "steps.jsonl").read_text().splitlines()) == 1
