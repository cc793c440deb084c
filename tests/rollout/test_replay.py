"""What was recorded is done again, then someone else goes on."""

import numpy as np
import pytest

from fakes_protocol import Hands, small_env
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.rollout.episode import run_episode
from lerobot_llakey.rollout.replay import Replay


def test_a_recorded_episode_comes_out_the_same() -> None:
    env = small_env("open_drawer", oracle_instructions=True)
    first = run_episode(env, Hands(), 4)
    joints = env.world.data.qpos.copy()
    again = run_episode(env, Replay(first.actions, first.instructions), 4)
    assert again == first and first.success
    assert np.array_equal(env.world.data.qpos, joints)
    half = run_episode(env, Replay(first.actions[:1], first.instructions[:1], Hands(wrong_hands=True)), 4)
    assert not half.success and half.actions[0] == first.actions[0] and half.instructions[0] == first.instructions[0]
    env.close()


def test_a_record_that_ends_too_early_is_told() -> None:
    env = small_env("open_drawer")
    with pytest.raises(LlakeyError, match="to end after its 0 recorded actions"):
        run_episode(env, Replay([], []), 0)
    env.close()
