"""The expert's word on every state that somebody else got into."""

import numpy as np
import pytest

from fakes_protocol import Hands, small_env
from lerobot_llakey import schema
from lerobot_llakey.dagger.episode import Frame, visited_frames
from lerobot_llakey.datasets.demonstrations import sim_features
from lerobot_llakey.sim.env import LlakeySimEnv


@pytest.fixture(scope="module")
def env() -> LlakeySimEnv:
    return small_env("open_drawer", "train", episode_length=8)


def visit(env: LlakeySimEnv, actor: Hands, expert_share: float = 0.0) -> list[Frame]:
    return visited_frames(env, actor, 5, np.random.default_rng(0), expert_share)


def said(frames: list[Frame]) -> list[str]:
    return [frame[schema.INSTRUCTION].split()[0] for frame in frames]


def test_right_actions_give_a_demonstration(env: LlakeySimEnv) -> None:
    frames = visit(env, Hands())
    assert said(frames) == ["move", "grasp", "pull"]
    assert [frame[schema.PREVIOUS_INSTRUCTION].split()[:1] for frame in frames] == [[], ["move"], ["grasp"]]
    assert [bool(frame[schema.IS_KEYFRAME][0]) for frame in frames] == [False, True, True]
    assert [float(frame[schema.STEP][0]) for frame in frames] == [0.0, 1.0, 2.0]
    assert max(np.abs(frame[schema.VELOCITY]).max() for frame in frames) < 1e-2


def test_after_a_wrong_action_the_label_is_what_the_expert_would_do_there(env: LlakeySimEnv) -> None:
    frames = visit(env, Hands(wrong_words=range(1, 2)))
    assert said(frames)[:2] == ["move", "grasp"] and said(frames)[-2:] == ["grasp", "pull"]
    after = frames[2]
    assert after[schema.PREVIOUS_INSTRUCTION] == "raise the robotic arm"
    assert not np.allclose(after[schema.STATE], frames[1][schema.STATE], atol=1e-3)
    # The label is a keyframe at or before the handle, not what the policy did.
    assert np.linalg.norm(after[schema.ACTION][:3] - frames[1][schema.ACTION][:3]) < 0.12


def test_the_expert_helps_a_policy_that_stands_still(env: LlakeySimEnv) -> None:
    frames = visit(env, Hands(wrong_hands=True))
    assert said(frames)[:4] == ["move", "move", "grasp", "grasp"] and "pull" in said(frames)
    states = [frame[schema.STATE] for frame in frames]
    assert np.allclose(states[0], states[1], atol=0.02) and not np.allclose(states[1], states[2], atol=0.02)


def test_the_expert_may_do_it_all(env: LlakeySimEnv) -> None:
    assert said(visit(env, Hands(wrong_hands=True), expert_share=1.0)) == ["move", "grasp", "pull"]


def test_from_a_disturbance_on_the_frames_bear_its_name() -> None:
    env = small_env("open_drawer", "train", episode_length=8, disturbance="empty_grasp")
    frames = visit(env, Hands())
    assert said(frames)[:2] == ["move", "grasp"] and said(frames).count("grasp") == 2
    events = [frame[schema.EPISODE_EVENT] for frame in frames]
    assert events == [""] * 2 + ["empty_grasp"] * (len(frames) - 2)


def test_frames_fit_the_contract(env: LlakeySimEnv) -> None:
    features = sim_features(32, "image")
    for frame in visit(env, Hands()):
        assert set(frame) == set(features) | {schema.TASK}
        assert frame[schema.EPISODE_TASK] == "open_drawer" and frame[schema.EPISODE_SEED] == 5
