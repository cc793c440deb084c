"""What one process does: episodes one after another, with the policy and the scene in use kept at hand."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import torch
from lerobot.utils.random_utils import set_seed

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol.blame import find_blame
from lerobot_llakey.evaluation.protocol.loading import load_row
from lerobot_llakey.evaluation.protocol.plan import Plan, Trial
from lerobot_llakey.evaluation.protocol.records import Record
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.rollout.actors import Actor, run_episode
from lerobot_llakey.sim.env import LlakeySimEnv


class _AtHand:
    """The policies of one row and the environment of one task: those in use, since others come in blocks later."""

    def __init__(self) -> None:
        self._row: Row | None = None
        self._actors: dict[bool, Actor] = {}
        self._scene: tuple[Any, ...] = ()
        self._env: LlakeySimEnv | None = None

    def actor(self, row: Row, oracle: bool = False) -> Actor:
        if row != self._row:
            self._row, self._actors = row, {}
        if oracle not in self._actors:
            self._actors[oracle] = load_row(row, oracle)
        return self._actors[oracle]

    def env(self, plan: Plan, trial: Trial) -> LlakeySimEnv:
        scene = (trial.task, trial.disturbance, plan.split, plan.max_steps)
        if self._env is None or scene != self._scene:
            if self._env is not None:
                self._env.close()
            self._scene, self._env = scene, make_env(plan, trial)
        return self._env


_at_hand = _AtHand()


def make_env(plan: Plan, trial: Trial, detailed: bool = False) -> LlakeySimEnv:
    """The environment of an episode.

    It always asks the expert what it would say: that is what blame rests on, and since the expert may draw from the
    scene's random numbers, an episode is the same again only where it is asked again.
    """
    return LlakeySimEnv(
        trial.task,
        plan.split,
        episode_length=plan.max_steps,
        oracle_instructions=True,
        disturbance=trial.disturbance,
        detailed=detailed,
    )


def run_trial(row: Row, plan: Plan, trial: Trial) -> Record:
    """Run one episode, and once more for the blame where it fails.

    The scene's seed fixes everything random, and computing is single-threaded, so that the result depends neither on
    what the process has done before nor on how many others there are.

    Raises:
        LlakeyError: if what was handed in is wrong, with the name of the episode.
        RuntimeError: at any other error, with the name of the episode.
    """
    with named(trial), single_threaded():
        started = time.perf_counter()
        env, actor = _at_hand.env(plan, trial), _at_hand.actor(row)
        seed = schema.scene_seed(plan.split, trial.scene)
        _seed(actor, seed)
        episode = run_episode(env, actor, trial.scene)
        blame, swapped_at = "", None
        if plan.blame and not episode.success and _has_levels(actor):

            def guided() -> Actor:
                guide = _at_hand.actor(row, oracle=True)
                _seed(guide, seed)
                return guide

            blame, swapped_at = find_blame(env, episode, guided)
        return Record(trial, episode, blame, swapped_at, time.perf_counter() - started)


@contextmanager
def named(trial: Trial) -> Iterator[None]:
    """Say in which episode an error came up."""
    try:
        yield
    except LlakeyError as error:
        raise LlakeyError(f"{error} It came up in {trial}.") from error
    except Exception as error:
        raise RuntimeError(f"{type(error).__name__} in {trial}: {error}") from error


@contextmanager
def single_threaded() -> Iterator[None]:
    """PyTorch on one thread: sums of several threads differ in their last bits."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)


def _seed(actor: Actor, seed: int) -> None:
    set_seed(seed)
    reseed = getattr(getattr(actor, "policy", None), "reseed", None)
    if reseed is not None:
        reseed(seed)


def _has_levels(actor: Actor) -> bool:
    """Whether someone says instructions to someone who acts; LeRobot's policies say none."""
    config = getattr(getattr(actor, "policy", None), "config", None)
    return getattr(config, "commander", "task") != "task"
