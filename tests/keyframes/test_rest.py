"""Keyframes on made-up trajectories: minimum-jerk moves between rests, as a simulator makes them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fakes_trajectories import SEGMENTS, fake_trajectory
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import continuous_quaternions
from lerobot_llakey.keyframes.rest import discover_keyframes, pose_numbers

FPS = 10.0


class Recording:
    """Builds a trajectory move by move and remembers where each waypoint was reached."""

    def __init__(self, rest: int = 4) -> None:
        self.arm = [np.zeros(7)] * rest
        self.gripper = [1.0] * rest
        self.waypoints: list[int] = []

    def move(
        self, arm: np.ndarray | None = None, gripper: float | None = None, frames: int = 10, rest: int = 3
    ) -> None:
        """Move over ``frames`` frames to a configuration, then stay for ``rest`` frames; rest -1 is no waypoint."""
        start, opening = self.arm[-1], self.gripper[-1]
        for u in np.arange(1, frames + 1) / frames:
            s = 10 * u**3 - 15 * u**4 + 6 * u**5
            self.arm.append(start if arm is None else start + s * (arm - start))
            self.gripper.append(opening if gripper is None else opening + s * (gripper - opening))
        if rest >= 0:
            self.waypoints.append(len(self.arm) - 1)
        self.arm += [self.arm[-1]] * max(rest, 0)
        self.gripper += [self.gripper[-1]] * max(rest, 0)

    def noisy(self, rng: np.random.Generator, noise: float) -> tuple[np.ndarray, np.ndarray]:
        arm, gripper = np.array(self.arm), np.array(self.gripper)
        return arm + rng.normal(0, noise, arm.shape), gripper + rng.normal(0, noise, gripper.shape)

    @property
    def expected(self) -> list[int]:
        return [*self.waypoints[:-1], len(self.arm) - 1]


def _random_recording(rng: np.random.Generator) -> Recording:
    recording = Recording(rest=int(rng.integers(1, 6)))
    for _ in range(rng.integers(1, 7)):
        rest = int(rng.integers(3, 8))
        kind = rng.integers(4)
        target = recording.arm[-1] + rng.choice([-1, 1], 7) * rng.uniform(0.05, 0.8, 7)
        opening = 0.4 if recording.gripper[-1] == 1.0 else 1.0
        frames = int(np.ceil(np.abs(target - recording.arm[-1]).max() / rng.uniform(0.05, 0.15))) + 3
        if kind == 0:
            recording.move(gripper=opening, frames=int(rng.integers(1, 6)), rest=rest)
        elif kind == 1:
            recording.move(target, frames=frames, rest=-1)
            recording.move(gripper=opening, frames=3, rest=rest)
        else:
            recording.move(target, frames=frames, rest=rest)
    return recording


@pytest.mark.parametrize("seed", range(40))
def test_one_keyframe_for_each_waypoint(seed: int) -> None:
    recording = _random_recording(np.random.default_rng(seed))
    found = discover_keyframes(recording.arm, recording.gripper, FPS)
    assert len(found) == len(recording.expected)
    # A smooth approach is within sub-milliradians of its end a frame early.
    assert np.abs(np.subtract(found, recording.expected)).max() <= 1
    assert np.abs(np.array(recording.arm)[found] - np.array(recording.arm)[recording.expected]).max() < 1e-3


@pytest.mark.parametrize("seed", range(40))
def test_noise_neither_adds_nor_hides_keyframes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    recording = _random_recording(rng)
    found = discover_keyframes(*recording.noisy(rng, 1e-3), FPS)
    assert len(found) == len(recording.expected)
    assert np.abs(np.subtract(found, recording.expected)).max() <= 2


@pytest.mark.parametrize("duration", [0.3, 1.0, 3.0])
def test_moves_of_every_duration_at_shortest_rest(duration: float) -> None:
    recording = Recording()
    for sign in (1, -1, 1):
        recording.move(recording.arm[-1] + sign * 0.3, frames=round(duration * FPS), rest=3)
    assert len(discover_keyframes(recording.arm, recording.gripper, FPS)) == 3


def test_gripper_that_closes_as_soon_as_the_arm_stops_is_part_of_the_same_keyframe() -> None:
    recording = Recording()
    recording.move(np.full(7, 0.5), rest=-1)
    recording.move(gripper=0.3, frames=4, rest=5)
    recording.move(np.zeros(7), rest=3)
    assert discover_keyframes(recording.arm, recording.gripper, FPS) == recording.expected


@pytest.mark.parametrize("seed", range(10))
def test_a_servo_that_lags_and_creeps_into_its_rest_gives_the_same_keyframes(seed: int) -> None:
    recording = _random_recording(np.random.default_rng(seed))
    arm = np.array(recording.arm)
    for frame in range(1, len(arm)):
        arm[frame] = arm[frame - 1] + 0.75 * (recording.arm[frame] - arm[frame - 1])
    found = discover_keyframes(arm, recording.gripper, FPS)
    assert len(found) == len(recording.expected)
    assert np.abs(np.subtract(found, recording.expected)).max() <= 2


def test_gripper_that_closes_between_two_frames_is_a_keyframe_of_its_own() -> None:
    recording = Recording()
    recording.move(np.full(7, 0.5), rest=4)
    recording.move(gripper=0.0, frames=1, rest=4)
    recording.move(np.zeros(7), rest=3)
    assert discover_keyframes(recording.arm, recording.gripper, FPS) == recording.expected


def test_recording_that_ends_while_moving_ends_with_a_keyframe() -> None:
    recording = Recording()
    recording.move(np.full(7, 0.5), rest=4)
    recording.move(np.zeros(7), rest=0)
    arm, gripper = recording.arm[:-4], recording.gripper[:-4]
    assert discover_keyframes(arm, gripper, FPS) == [recording.waypoints[0], len(arm) - 1]


def test_nothing_moves_gives_only_the_last_frame() -> None:
    assert discover_keyframes(np.zeros((8, 7)), np.ones(8), FPS) == [7]


def test_a_spike_within_a_rest_is_no_motion() -> None:
    recording = Recording()
    recording.move(np.full(7, 0.5), rest=9)
    recording.move(np.zeros(7), rest=3)
    arm = np.array(recording.arm)
    arm[recording.waypoints[0] + 4, 2] += 0.05
    assert discover_keyframes(arm, recording.gripper, FPS) == recording.expected


@pytest.mark.parametrize("fps", [10.0, 30.0, 100.0])
def test_keyframes_do_not_depend_on_the_frame_rate(fps: float) -> None:
    recording = Recording(rest=round(0.4 * fps))
    recording.move(np.full(7, 0.5), frames=round(fps), rest=round(0.4 * fps))
    recording.move(gripper=0.0, frames=round(0.2 * fps), rest=round(0.4 * fps))
    found = discover_keyframes(recording.arm, recording.gripper, fps)
    assert np.allclose(np.divide(found, fps), np.divide(recording.expected, fps), atol=0.1)


@pytest.mark.parametrize("joints", [0, 5, 6, 7])
@pytest.mark.parametrize("fps", [5, 10, 15, 30])
def test_arms_of_any_number_of_joints_with_noise_and_hesitations(joints: int, fps: int) -> None:
    """No joints stands for a hand of which the pose alone is known."""
    rng = np.random.default_rng(joints)
    for _ in range(10):
        poses, openings, commands, _held = fake_trajectory(np.array([0.3, rng.uniform(-0.1, 0.1), 0.04]), fps, rng)
        poses[:, :3] += rng.normal(0, 4e-4, (len(poses), 3))
        turns = Rotation.from_rotvec(rng.normal(0, 1e-3, (len(poses), 3))) * Rotation.from_quat(poses[:, 3:])
        poses[:, 3:] = continuous_quaternions(turns.as_quat())
        arm, tolerance = pose_numbers(poses, 0.004, 0.02), 1.0
        if joints:
            mixing = rng.uniform(1, 3, (3, joints)) * rng.choice([-1, 1], (3, joints))
            arm, tolerance = poses[:, :3] @ mixing, 0.01
        found = discover_keyframes(arm, openings, fps, arm_tolerance=tolerance)
        assert len(found) == SEGMENTS
        # The second keyframe is the grasp, which the command precedes.
        assert found[0] < np.argmax(commands == 0) < found[1]


def test_a_hand_that_only_turns_moves() -> None:
    angles = np.concatenate((np.zeros(5), np.linspace(0, 3, 20), np.full(6, 3.0), np.linspace(3, 7, 20), np.full(5, 7)))
    turns = continuous_quaternions(Rotation.from_euler("z", angles[:, None]).as_quat())
    poses = np.concatenate((np.full((len(angles), 3), 0.3), turns), axis=1)
    arm = pose_numbers(poses, 0.004, 0.02)
    assert discover_keyframes(arm, np.ones(len(arm)), FPS, arm_tolerance=1.0) == [24, len(arm) - 1]


@pytest.mark.parametrize(
    ("arm", "gripper", "message"),
    [
        (np.zeros((5, 7)), np.zeros(4), "T >= 2"),
        (np.zeros((1, 7)), np.zeros(1), "T >= 2"),
        (np.zeros(7), np.zeros(7), "T >= 2"),
        (np.full((5, 7), np.nan), np.zeros(5), "finite"),
    ],
)
def test_bad_trajectories_are_refused(arm: np.ndarray, gripper: np.ndarray, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        discover_keyframes(arm, gripper, FPS)


@pytest.mark.parametrize("setting", ["fps", "min_rest", "arm_tolerance", "gripper_tolerance"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_a_setting_must_make_sense(setting: str, value: float) -> None:
    settings = {"fps": FPS, setting: value}
    with pytest.raises(LlakeyError, match=f"Expected {setting} "):
        discover_keyframes(np.zeros((5, 7)), np.zeros(5), **settings)
