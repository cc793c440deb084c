"""The environment as LeRobot meets it."""

import itertools
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from lerobot.envs.utils import NEW_ROLLOUT_OPTION, preprocess_observation

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import canonical_quaternion
from lerobot_llakey.sim.configuration_llakey_sim import LlakeySimConfig
from lerobot_llakey.sim.env import LlakeySimEnv
from lerobot_llakey.sim.text_codes import decode_text


def _expert_action(env: LlakeySimEnv) -> np.ndarray:
    waypoint = env.expert_waypoint()
    assert waypoint is not None
    flags = (waypoint.gripper_open, waypoint.ignore_collision)
    return np.array((*waypoint.pose.position, *waypoint.pose.quaternion, *flags), dtype=np.float32)


@pytest.fixture(scope="module")
def env() -> LlakeySimEnv:
    return LlakeySimEnv("open_drawer", image_size=48, oracle_instructions=True)


def test_experts_actions_solve_an_episode(env: LlakeySimEnv) -> None:
    observation, info = env.reset(seed=0)
    assert env.observation_space.contains(observation) and not info["is_success"]
    waypoint = env.expert_waypoint()
    assert waypoint is not None
    assert decode_text(observation["oracle_instruction"]) == env.oracle_instruction() == waypoint.instruction
    for taken in range(10):
        assert observation["step"] == taken
        observation, reward, terminated, truncated, info = env.step(_expert_action(env))
        assert info["moved"] and not truncated
        if terminated:
            break
    assert terminated and reward == 1.0 and info["is_success"]


def test_the_last_pictures_are_those_of_the_observation(env: LlakeySimEnv) -> None:
    env.reset(seed=0)
    observation, *_ = env.step(_expert_action(env))
    assert list(env.pictures) == list(schema.CAMERAS)
    for camera, picture in env.pictures.items():
        assert np.array_equal(picture.rgb, observation["pixels"][camera])
        assert np.array_equal(picture.depth[None], observation[f"images.{camera}_depth"])


def test_quaternions_keep_their_sign_where_w_passes_zero(env: LlakeySimEnv) -> None:
    states = [env.reset(seed=0)[0]["agent_pos"]]
    for tilt in (0.15, -0.15, 0.15):
        action = np.array(_STAY)
        action[schema.QUATERNION] = canonical_quaternion(np.array((1.0, 0.0, 0.0, tilt)))
        observation, *_, info = env.step(action)
        assert info["moved"]
        states.append(observation["agent_pos"])
        wrist = observation["camera_extrinsics.wrist"]
        np.testing.assert_array_equal(wrist, env.pictures["wrist"].pose)
    quaternions = np.stack(states)[:, schema.QUATERNION]
    assert (quaternions[:, 0] > 0.9).all() and (np.sign(quaternions[1:, 3]) == (1, -1, 1)).all()


def test_unreachable_is_a_step_without_motion(env: LlakeySimEnv) -> None:
    before, _ = env.reset(seed=1)
    far = np.array([1.9, 0, 0.4, 1, 0, 0, 0, 1, 0], dtype=np.float32)
    after, reward, terminated, truncated, info = env.step(far)
    assert info["failure"] == "unreachable" and not info["moved"]
    assert not terminated and not truncated and reward == 0.0
    assert np.allclose(before["agent_pos"], after["agent_pos"], atol=1e-3)


def test_the_robot_stands_when_it_is_asked(env: LlakeySimEnv) -> None:
    env.reset(seed=0)
    observation, *_ = env.step(_expert_action(env))
    assert np.abs(observation["velocity"]).max() < 1e-2
    assert preprocess_observation(dict(observation))[schema.VELOCITY].shape[-1] == len(schema.SIM_VELOCITY_NAMES)


_STAY = (0.4, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0)


def _changed(column: int, value: float) -> np.ndarray:
    action = np.array(_STAY)
    action[column] = value
    return action


@pytest.mark.parametrize(
    "action",
    [
        np.zeros(8),
        np.zeros((1, 9)),
        np.full(9, np.nan),
        _changed(0, np.inf),
        _changed(schema.GRIPPER, np.nan),
        np.array(_STAY, dtype=complex),
        np.array(_STAY, dtype=str),
        [[1.0], [2.0, 3.0]],
        None,
    ],
)
def test_what_is_no_action_is_refused(env: LlakeySimEnv, action: Any) -> None:
    env.reset(seed=1)
    with pytest.raises(LlakeyError, match=r"Expected .*, got .*;"):
        env.step(action)


@pytest.mark.parametrize(
    "action",
    [
        np.array([0.4, 0, 0.3, 0, 0, 0, 0, 1, 0]),
        np.array([0.4, 0, 0.3, 0, 0, 0, 1e-20, 1, 0]),
        *(np.array(_STAY) * np.where(np.arange(9) == 3, scale, 1) for scale in (0.01, 100.0, 1e155, 1.7e308)),
        _changed(schema.GRIPPER, 255.0),
        _changed(schema.GRIPPER, -1.0),
        _changed(schema.IGNORE_COLLISION, -100.0),
    ],
)
def test_what_an_untrained_regression_gives_moves_nothing(
    env: LlakeySimEnv, action: np.ndarray, caplog: pytest.LogCaptureFixture
) -> None:
    before = env.reset(seed=1)[0]["agent_pos"]
    after, _, terminated, _, info = env.step(action)
    np.testing.assert_allclose(after["agent_pos"], before, atol=1e-3)
    assert not terminated and info["failure"] == "unreachable"
    assert "check the units" in caplog.text


@pytest.mark.parametrize("far", [1e5, -1e7, 1e17, 1e300, 1.7e308])
@pytest.mark.parametrize("disturbance", ["", "execution_noise", "drop"])
def test_far_poses_are_unreachable_without_a_single_planned_sample(
    env: LlakeySimEnv, far: float, disturbance: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(env, "disturbance", disturbance)
    env.reset(seed=1)
    solved: list[None] = []
    monkeypatch.setattr(env.world.planner.kinematics, "solve", lambda *_, **__: solved.append(None))
    for column in range(3):
        *_, info = env.step(_changed(column, far))
        assert info["failure"] == "unreachable" and not info["moved"]
    assert not solved


@pytest.mark.parametrize("length", [0.2, 5.0])
def test_quaternions_of_about_unit_length_say_the_same(env: LlakeySimEnv, length: float) -> None:
    states = []
    for scale in (1.0, length):
        env.reset(seed=1)
        action = np.array(_STAY)
        action[schema.QUATERNION] *= scale
        observation, *_, info = env.step(action)
        assert info["moved"]
        states.append(observation["agent_pos"])
    assert np.allclose(*states, atol=1e-5)


def test_an_episode_has_to_be_begun() -> None:
    env = LlakeySimEnv("open_drawer", image_size=48)
    calls = (lambda: env.step(np.array(_STAY)), env.render, env.expert_waypoint)
    for call in calls:
        with pytest.raises(LlakeyError, match=r"Expected reset\(\) before"):
            call()
    env.reset(seed=0)
    env.step(np.array(_STAY))
    env.close()
    for call in calls:
        with pytest.raises(LlakeyError, match=r"Expected reset\(\) before"):
            call()
    env.reset(seed=0)
    assert env.step(np.array(_STAY))[-1]["moved"]


@pytest.mark.parametrize("seed", [-1, 100_000_000, 10**30, 1.5, "3", True])
def test_seeds_out_of_range_are_refused(env: LlakeySimEnv, seed: Any) -> None:
    with pytest.raises(LlakeyError, match="Expected the seed to be a whole number"):
        env.reset(seed=seed)


@pytest.mark.parametrize("variation", [-1, 99, 1.5, "1"])
def test_variations_out_of_range_are_refused(env: LlakeySimEnv, variation: Any) -> None:
    with pytest.raises(LlakeyError, match="Expected the variation of open_drawer"):
        env.reset(seed=0, options={"variation": variation})


def test_options_are_known(env: LlakeySimEnv) -> None:
    env.reset(seed=np.int64(0), options={"variation": np.int64(1), NEW_ROLLOUT_OPTION: True})
    with pytest.raises(LlakeyError, match="'variaton'"):
        env.reset(seed=0, options={"variaton": 1})


def test_unstable_physics_are_told(
    env: LlakeySimEnv, caplog: pytest.LogCaptureFixture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log file
    env.reset(seed=0)
    env.world.data.qvel[0] = np.nan
    env.step(np.array(_STAY))
    assert "BADQVEL" in caplog.text
    caplog.clear()
    env.step(np.array(_STAY))
    assert not caplog.text


@pytest.mark.parametrize("fps", [0, -1.0, float("nan")])
def test_a_rate_of_watching_is_above_zero(env: LlakeySimEnv, fps: float) -> None:
    with pytest.raises(LlakeyError, match="frames a second"):
        env.watch(lambda _: None, fps=fps)


def test_episodes_are_cut_off() -> None:
    env = LlakeySimEnv("open_drawer", image_size=48, episode_length=2)
    env.reset(seed=0)
    stay = np.array([*env.world.tool.position, *env.world.tool.quaternion, 1, 1])
    assert env.step(stay)[3] is False
    assert env.step(stay)[3] is True


def test_splits_are_different_scenes() -> None:
    scenes = []
    for split in ("train", "test"):
        env = LlakeySimEnv("open_drawer", split=split, image_size=48)
        env.reset(seed=3)
        scenes.append(env.world.model.body("cabinet").pos.copy())
    assert not np.allclose(*scenes)
    with pytest.raises(ValueError, match="Expected a split"):
        LlakeySimEnv("open_drawer", split="holdout")
    with pytest.raises(ValueError, match="Expected tasks"):
        LlakeySimEnv("fold_laundry")


def test_every_simulated_frame_can_be_watched(env: LlakeySimEnv) -> None:
    frames: list[np.ndarray] = []
    env.watch(frames.append, fps=10)
    env.reset(seed=0)
    env.step(_expert_action(env))
    env.watch(None)
    assert len(frames) > 5 and frames[0].shape == (480, 640, 3)
    assert any(not np.array_equal(a, b) for a, b in itertools.pairwise(frames))


@pytest.mark.parametrize("asynchronous", [False, True])
def test_vector_environments_show_the_same_pixels(env: LlakeySimEnv, asynchronous: bool) -> None:
    config = LlakeySimConfig(task="open_drawer", image_size=48)
    vector = config.create_envs(2, use_async_envs=asynchronous)["open_drawer"][0]
    try:
        observation, _ = vector.reset(seed=[4, 5], options={NEW_ROLLOUT_OPTION: True})
        assert [str(text) for text in vector.call("task")] == ["open_drawer"] * 2
        assert vector.call("_max_episode_steps")[0] == 25
        for row, seed in enumerate((4, 5)):
            alone, _ = env.reset(seed=seed)
            for camera in schema.CAMERAS:
                assert np.array_equal(observation["pixels"][camera][row], alone["pixels"][camera])
        batch = preprocess_observation(observation)
        assert batch[schema.depth_key("wrist")].shape == (2, 1, 48, 48)
        assert batch[schema.intrinsics_key("wrist")].shape == (2, 4)
        assert batch[schema.extrinsics_key("wrist")].shape == (2, 7)
        assert batch[schema.STATE].shape == (2, 15)
    finally:
        vector.close()


def test_it_is_a_gymnasium_environment(env: LlakeySimEnv) -> None:
    assert isinstance(env, gym.Env)
    assert env.task_description
