"""PerAct's keyframes: gripper, stops, the last frame."""

import numpy as np

from fakes_rlbench import RecordedFrames
from lerobot_llakey import schema
from lerobot_llakey.converters.rlbench_keyframes import keypoints


def speeds(length: int, still: tuple[int, ...] = ()) -> np.ndarray:
    values = np.full((length, 7), 0.5)
    values[list(still)] = 0.05
    return values


def test_the_last_frame_is_always_a_keyframe() -> None:
    assert keypoints(np.ones(9, bool), speeds(9)) == [8]


def test_a_stop_is_a_keyframe_and_not_again_within_four_frames() -> None:
    assert keypoints(np.ones(30, bool), speeds(30, (10, 11, 12, 13, 14, 15))) == [10, 15, 29]
    assert keypoints(np.ones(30, bool), speeds(30, (10, 14))) == [10, 29]


def test_a_joint_that_moves_is_no_stop() -> None:
    moving = speeds(20, (8,))
    moving[8, 3] = -0.11
    assert keypoints(np.ones(20, bool), moving) == [19]


def test_a_change_of_the_gripper_is_a_keyframe_and_hides_stops_beside_it() -> None:
    gripper = np.arange(30) < 12
    assert keypoints(gripper, speeds(30)) == [12, 29]
    for near in (11, 13):  # the frame after is closed already; two frames before, it was still open
        assert keypoints(gripper, speeds(30, (near,))) == [12, 29]
    assert keypoints(gripper, speeds(30, (10,))) == [10, 12, 29]
    assert keypoints(gripper, speeds(30, (14,))) == [12, 14, 29]


def test_of_two_keyframes_at_the_end_the_last_stays() -> None:
    assert keypoints(np.arange(20) < 18, speeds(20)) == [19]


def test_the_experts_keyframes_are_found(frames: RecordedFrames) -> None:
    states = frames.episode.states[frames.steps]
    found = keypoints(states[:, schema.GRIPPER] > 0.9, frames.episode.velocities[frames.steps, :7])
    assert found == frames.keyframes
