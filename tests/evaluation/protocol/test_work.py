"""An episode depends on its scene alone, and an error says where it came up."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch

from fakes_protocol import Hands, small_env
from lerobot_llakey import parallel
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol import work
from lerobot_llakey.evaluation.protocol.plan import Plan, Trial
from lerobot_llakey.evaluation.protocol.records import ACTION, COMMAND
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.evaluation.protocol.work import run_trial
from lerobot_llakey.rollout.actors import Agent, Expert

PLAN = Plan(("open_drawer",), 2, 1, max_steps=6)
ROW = Row("a", "x")


def _trial(episode: int) -> Trial:
    return Trial("a", "open_drawer", "", 0, episode, episode)


@pytest.fixture
def acts(monkeypatch: pytest.MonkeyPatch):
    """Let somebody act in place of the row's checkpoint; by themselves, and with the oracle's instructions."""

    def put(alone, guided=None) -> None:
        monkeypatch.setattr(parallel, "_kept", {})
        monkeypatch.setattr(work, "LlakeySimEnv", small_env)
        monkeypatch.setattr(work, "load_row", lambda row, oracle=False: guided if oracle else alone)

    return put


class _Restless(Hands):
    """Draws from the generator that everybody shares."""

    def act(self, env, observation):  # type: ignore[no-untyped-def]
        action, instruction = super().act(env, observation)
        return np.concatenate((action[:3] + 0.05 * torch.rand(3).numpy(), action[3:])), instruction


def test_the_order_of_episodes_does_not_matter(acts) -> None:
    acts(_Restless())
    first, second = run_trial(ROW, PLAN, _trial(0)), run_trial(ROW, PLAN, _trial(1))
    acts(_Restless())
    torch.rand(7)
    again_second, again_first = run_trial(ROW, PLAN, _trial(1)), run_trial(ROW, PLAN, _trial(0))
    assert first.episode == again_first.episode and second.episode == again_second.episode
    assert first.episode.actions != second.episode.actions
    assert first.seconds > 0 and first.trial == _trial(0)


def test_the_policys_own_random_numbers_follow_the_scene(acts) -> None:
    hands = Hands()
    acts(hands)
    run_trial(ROW, PLAN, _trial(1))
    assert hands.seed == 200_000_001


def test_a_policy_is_told_the_rows_wording_and_loaded_once_for_all_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[tuple[str, str]] = []

    class Listener(Agent):
        def act(self, env, observation):  # type: ignore[no-untyped-def]
            told.append((env.task_description, self.wording(env.task_description, 0) if self.wording else ""))
            return Expert().act(env, observation)

    loaded: list[str] = []

    def load_row(row: Row) -> Listener:
        loaded.append(row.policy_path)
        return Listener(SimpleNamespace(reset=lambda: None), None, None)  # type: ignore[arg-type]

    monkeypatch.setattr(parallel, "_kept", {})
    monkeypatch.setattr(work, "LlakeySimEnv", small_env)
    monkeypatch.setattr(work, "load_row", load_row)
    plan = Plan(("open_drawer",), 1, 1, max_steps=1, attribution=False)
    for row in (ROW, Row("louder", "x", wording=_loud), Row("other", "y")):
        run_trial(row, plan, _trial(0))
    assert [loud for _, loud in told] == ["", told[0][0].upper(), ""]
    assert loaded == ["x", "y"]


def _loud(description: str, sequence: int) -> str:
    return description.upper()


def test_failures_are_put_down_to_a_level(acts) -> None:
    acts(Hands(wrong_words=range(1, 99)), Hands())
    record = run_trial(ROW, PLAN, _trial(0))
    assert (record.attribution, record.swapped_at, record.episode.success) == (COMMAND, 1, False)
    acts(Hands(wrong_hands=True), Hands(wrong_hands=True))
    assert run_trial(ROW, PLAN, _trial(0)).attribution == ACTION


def test_no_blame_without_two_levels_or_where_it_is_not_wanted(acts) -> None:
    acts(Hands(wrong_hands=True, commander="task"))
    assert run_trial(ROW, PLAN, _trial(0)).attribution == ""
    acts(Hands(wrong_hands=True))
    assert run_trial(ROW, Plan(("open_drawer",), 2, 1, max_steps=2, attribution=False), _trial(0)).attribution == ""


class _Fails(Hands):
    def __init__(self, error: Exception) -> None:
        super().__init__()
        self.error = error

    def act(self, env, observation):  # type: ignore[no-untyped-def]
        raise self.error


@pytest.mark.parametrize("error", [KeyError("x"), LlakeyError("Expected three views, got one; add two.")])
def test_an_error_names_its_episode(acts, error: Exception) -> None:
    acts(_Fails(error))
    with pytest.raises((RuntimeError, ValueError), match=r"episode 1 of repeat 0 of open_drawer .* row 'a'") as info:
        run_trial(ROW, PLAN, _trial(1))
    assert isinstance(info.value, RuntimeError) == isinstance(error, KeyError)
    assert str(info.value).startswith("Expected three") == isinstance(error, ValueError)
