"""A failure is put down to the level that was made to fail."""

from collections.abc import Iterator

import pytest

from fakes_protocol import Hands, small_env
from lerobot_llakey.evaluation.protocol.failure_attribution import attribute_failure, first_difference
from lerobot_llakey.evaluation.protocol.records import ACTION, COMMAND
from lerobot_llakey.rollout.episode import Episode, run_episode
from lerobot_llakey.sim.env import LlakeySimEnv


@pytest.fixture(scope="module")
def env() -> Iterator[LlakeySimEnv]:
    env = small_env("open_drawer", oracle_instructions=True, episode_length=6)
    yield env
    env.close()


def _never() -> Hands:
    raise AssertionError("the oracle was asked although no instruction differed")


def test_wrong_words_are_found(env: LlakeySimEnv) -> None:
    failure = run_episode(env, Hands(wrong_words=range(1, 99)), 0)
    assert not failure.success
    assert attribute_failure(env, failure, Hands) == (COMMAND, 1)


def test_wrong_hands_are_found_without_another_run(env: LlakeySimEnv) -> None:
    failure = run_episode(env, Hands(wrong_hands=True), 0)
    assert not failure.success and failure.instructions == failure.oracle
    assert attribute_failure(env, failure, _never) == (ACTION, None)


def test_hands_that_fail_with_the_right_words_too_are_to_blame(env: LlakeySimEnv) -> None:
    failure = run_episode(env, Hands(wrong_words=range(2, 99), wrong_hands=True), 0)
    assert attribute_failure(env, failure, lambda: Hands(wrong_hands=True)) == (ACTION, 2)


def test_up_to_the_first_wrong_word_it_is_the_same_episode(env: LlakeySimEnv) -> None:
    failure = run_episode(env, Hands(wrong_words=range(2, 99)), 0)
    seen: list[list[float]] = []

    class _Watcher(Hands):
        def act(self, env, observation):  # type: ignore[no-untyped-def]
            seen.append(observation["agent_pos"].tolist())
            return super().act(env, observation)

    before: list[list[float]] = []

    class _First(Hands):
        def act(self, env, observation):  # type: ignore[no-untyped-def]
            before.append(observation["agent_pos"].tolist())
            return super().act(env, observation)

    run_episode(env, _First(wrong_words=range(2, 99)), 0)
    assert attribute_failure(env, failure, _Watcher) == (COMMAND, 2)
    assert seen[0] == before[2]


def test_wordings_of_one_template_and_a_silent_expert_make_no_difference() -> None:
    said = ["grab the lid", "raise the robotic arm", "release the lid"]
    wanted = ["grasp the lid", "", "grasp the lid"]
    episode = Episode("", "", 0, 0, 0, False, said, [""] * 3, wanted)
    assert first_difference(episode) == 2
    assert first_difference(Episode("", "", 0, 0, 0, False, said[:2], [""] * 2, wanted[:2])) is None
