"""One episode of a dataset: keyframes, words, pictures, cloud."""

from pathlib import Path

import numpy as np
import pytest

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.inspection.episode_look import EpisodeLook


def test_an_episode_is_read(tmp_path: Path) -> None:
    dataset = fake_keysteps(tmp_path / "data", frames=6)
    look = EpisodeLook(dataset, 1)
    assert len(look) == 6 and [reached.frame for reached in look.keyframes] == [3, 5]
    assert look.task.startswith("pick up the ") and look.cameras == schema.CAMERAS
    above, grasped = look.keyframes
    assert above.instruction.startswith("move to the top of") and grasped.instruction.startswith("grasp")
    assert above.action[schema.GRIPPER] == 1 and grasped.action[schema.GRIPPER] == 0
    moment = look.moment(3)
    assert moment.is_keyframe and moment.seconds == pytest.approx(0.3)
    assert (moment.leads, moment.next) == (above.instruction, grasped.instruction)
    assert np.allclose(moment.hand[schema.POSITION], above.action[schema.POSITION], atol=1e-5)
    assert moment.images["wrist"].dtype == np.uint8 and moment.images["wrist"].shape == (32, 32, 3)
    assert len(moment.points) == len(moment.colours) > 100 and moment.colours.max() <= 1
    assert [one.frame for one in look.moments()] == list(range(6))
    assert not look.moment(1).is_keyframe and not look.moment(1).leads


def test_what_is_no_episode_is_refused(tmp_path: Path) -> None:
    dataset = fake_keysteps(tmp_path / "data", episodes=1, frames=2)
    with pytest.raises(LlakeyError, match=r"from 0 to 0, got 1; correct --episode"):
        EpisodeLook(dataset, 1)
    bare = fake_keysteps(tmp_path / "bare", episodes=1, frames=2, without=[schema.IS_KEYFRAME])
    with pytest.raises(LlakeyError, match=r"with keyframe\.is_keyframe.* llakey annotate"):
        EpisodeLook(bare, 0)


def test_without_depth_there_is_no_cloud(tmp_path: Path) -> None:
    without = [schema.depth_key(camera) for camera in schema.CAMERAS]
    dataset = fake_keysteps(tmp_path / "data", episodes=1, frames=2, without=without)
    moment = EpisodeLook(dataset, 0).moment(0)
    assert moment.points.shape == (0, 3) and set(moment.images) == set(schema.CAMERAS)
