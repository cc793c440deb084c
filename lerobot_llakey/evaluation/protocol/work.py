"""What one process does: episodes one after another, with the policy and the scene in use kept at hand."""

from __future__ import annotations

import functools
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import torch

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol.failure_attribution import attribute_failure
from lerobot_llakey.evaluation.protocol.loading import load_row
from lerobot_llakey.evaluation.protocol.plan import Plan, Trial
from lerobot_llakey.evaluation.protocol.records import Record
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.parallel import kept
from lerobot_llakey.rollout.actors import Actor, Agent
from lerobot_llakey.rollout.episode import run_episode
from lerobot_llakey.sim.env import LlakeySimEnv


class _Actors:
    """The policy of a row as it is, and as it follows the oracle's instructions, each loaded when first asked for."""

    def __init__(self, row: Row) -> None:
        self._row = row

    @functools.cached_property
    def alone(self) -> Actor:
        return load_row(self._row)

    @functools.cached_property
    def guided(self) -> Actor:
        return load_row(self._row, oracle=True)


def make_env(task: str, disturbance: str, split: str, max_steps: int, detailed: bool = False) -> LlakeySimEnv:
    """The environment of an episode.

    It always asks the expert for its instruction: failure attribution needs it, and since the expert may draw from the
    scene's random numbers, an episode repeats only if the expert is asked again.
    """
    return LlakeySimEnv(
        task, split, episode_length=max_steps, oracle_instructions=True, disturbance=disturbance, detailed=detailed
    )


def run_trial(row: Row, plan: Plan, trial: Trial) -> Record:
    """Run one episode, and once more for the attribution where it fails.

    The scene's seed fixes everything random, and computing is single-threaded, so that the result depends neither on
    what the process has done before nor on how many others there are.

    Raises:
        LlakeyError: if what was handed in is wrong, with the name of the episode.
        RuntimeError: at any other error, with the name of the episode.
    """
    with named(trial), single_threaded():
        started = time.perf_counter()
        env = kept(make_env, trial.task, trial.disturbance, plan.split, plan.max_steps)
        actors = kept(_Actors, replace(row, name="", wording=None))
        episode = run_episode(env, _told(actors.alone, row), trial.scene)
        attribution, swapped_at = "", None
        if plan.attribution and not episode.success and _has_levels(actors.alone):
            attribution, swapped_at = attribute_failure(env, episode, lambda: _told(actors.guided, row))
        return Record(trial, episode, attribution, swapped_at, time.perf_counter() - started)


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


def _told(actor: Actor, row: Row) -> Actor:
    """An actor that is told the skill in the row's words."""
    return replace(actor, wording=row.wording) if row.wording and isinstance(actor, Agent) else actor


def _has_levels(actor: Actor) -> bool:
    """Whether someone says instructions to someone who acts; LeRobot's policies say none."""
    config = getattr(getattr(actor, "policy", None), "config", None)
    return getattr(config, "commander", "task") != "task"
