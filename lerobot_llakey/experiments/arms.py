"""The arms of figure 1: which policy, trained with which wording, is tested with which, and running their episodes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from lerobot.utils.random_utils import set_seed
from tqdm import tqdm

from lerobot_llakey.evaluation.protocol.loading import load_row
from lerobot_llakey.evaluation.protocol.plan import Plan, Trial
from lerobot_llakey.evaluation.protocol.records import Record, Records
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.evaluation.protocol.work import make_env, named, single_threaded
from lerobot_llakey.experiments.stages import Clock
from lerobot_llakey.experiments.wordings import TASK_NAME, TESTS, tested_wording
from lerobot_llakey.parallel import run_jobs
from lerobot_llakey.rollout.actors import Actor, Agent, run_episode
from lerobot_llakey.sim.env import LlakeySimEnv
from lerobot_llakey.sim.settings import MAX_STEPS

LLAKEY, BASELINE = "LLaKey", "baseline"


@dataclass(frozen=True)
class Arm:
    """One policy under one test.

    Attributes:
        method: LLAKEY or BASELINE.
        training: "one" or "two" wordings.
        test: out of TESTS.
        policy_path: of the baseline.
        command_path, action_path: of LLaKey.
    """

    method: str
    training: str
    test: str
    policy_path: str = ""
    command_path: str = ""
    action_path: str = ""

    @property
    def row(self) -> Row:
        """As a row of a table."""
        wordings = "one wording" if self.training == "one" else "two wordings"
        name = f"{self.method}, {wordings}, {TESTS[self.test]}"
        return Row(name, self.policy_path, self.command_path, self.action_path)


class Worded:
    """Tells a policy the skill in another wording than the environment's.

    Args:
        agent: the policy.
        training: wordings that it was trained with.
        test: wording that it is told.
    """

    def __init__(self, agent: Agent, training: str, test: str) -> None:
        self._agent, self._training, self._test = agent, training, test

    def reset(self) -> None:
        """Forget the last episode."""
        self._agent.reset()

    def act(self, env: LlakeySimEnv, observation: Mapping[str, Any]) -> tuple[np.ndarray, str]:
        """Action (9,) for one unbatched observation, and the basic instruction behind it."""
        task = tested_wording(self._training, self._test, env.task_description, env.simulation.task.sequence)
        action = self._agent.act_on(self._agent.batch(task, observation))
        instructions = getattr(self._agent.policy, "last_instructions", None) or [""]
        return action, instructions[0]


def make_arms(tests: Sequence[str], policies: Mapping[tuple[str, str], Path], action: Path | None) -> list[Arm]:
    """All arms.

    Args:
        tests: wordings tested.
        policies: checkpoints by method and training; of LLaKey its command policy.
        action: checkpoint of LLaKey's action policy.
    """
    arms: list[Arm] = []
    for (method, training), path in policies.items():
        paths = {"command_path": str(path), "action_path": str(action)}
        arms += [
            Arm(method, training, test, **(paths if method == LLAKEY else {"policy_path": str(path)})) for test in tests
        ]
    return arms


def make_plan(num_episodes: int, repeats: int, max_steps: int = MAX_STEPS, split: str = "test") -> Plan:
    """The episodes of each arm."""
    return Plan((TASK_NAME,), num_episodes, repeats, max_steps, split, blame=False)


def run_arms(arms: Sequence[Arm], plan: Plan, records: Records, num_workers: int) -> None:
    """Run all episodes that have no record yet, showing progress.

    Args:
        arms: to run.
        plan: the protocol.
        records: of the episodes that are done; grows.
        num_workers: processes; one for each CPU core where 0.
    """
    by_row = {arm.row.name: arm for arm in arms}
    trials = plan.trials([arm.row for arm in arms])
    jobs = [(by_row[trial.row], plan, trial) for trial in trials if trial not in records]
    with tqdm(total=len(trials), initial=len(trials) - len(jobs), desc="episodes", unit="episode") as progress:
        for record in run_jobs(run_trial, jobs, num_workers):
            records.add(record)
            progress.update()


_actor: tuple[str, Actor] | None = None
_env: tuple[str, LlakeySimEnv] | None = None


def run_trial(arm: Arm, plan: Plan, trial: Trial) -> Record:
    """Run one episode; everything random follows from its scene's seed.

    Raises:
        LlakeyError: if what was handed in is wrong, with the name of the episode.
        RuntimeError: at any other error, with the name of the episode.
    """
    with named(trial), single_threaded():
        spent = Clock()
        agent = _agent(arm)
        set_seed(trial.scene)
        reseed = getattr(agent.policy, "reseed", None)
        if reseed is not None:
            reseed(trial.scene)
        episode = run_episode(_scene(plan, trial), Worded(agent, arm.training, arm.test), trial.scene)
        return Record(trial, episode, "", None, spent.read()[0])


def _agent(arm: Arm) -> Agent:
    """The arm's policy, loaded where the last episode was of another one."""
    global _actor
    key = f"{arm.policy_path} {arm.command_path} {arm.action_path}"
    if _actor is None or _actor[0] != key:
        _actor = key, load_row(arm.row)
    assert isinstance(_actor[1], Agent)
    return _actor[1]


def _scene(plan: Plan, trial: Trial) -> LlakeySimEnv:
    """The environment, made where the last episode was of another protocol."""
    global _env
    key = json.dumps(asdict(plan))
    if _env is None or _env[0] != key:
        if _env is not None:
            _env[1].close()
        _env = key, make_env(plan, trial)
    return _env[1]
