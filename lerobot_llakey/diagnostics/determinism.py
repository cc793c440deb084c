"""Whether a seed fixes a scene to the last bit: in any process, in any run, in any kind of vector environment."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from tqdm import tqdm

from lerobot_llakey.parallel import process_pool
from lerobot_llakey.rollout.actors import Expert
from lerobot_llakey.rollout.episode import Observer, run_episode
from lerobot_llakey.rollout.replay import Replay
from lerobot_llakey.sim.configuration_llakey_sim import LlakeySimConfig
from lerobot_llakey.sim.env import LlakeySimEnv

_ACTIONS = 3
WAYS = ("here", "here again", "another process", "sync vector", "async vector")
"""Where the same episode is run."""


def determinism(tasks: Sequence[str], seed: int = 0, split: str = "val") -> dict[str, dict[str, str]]:
    """Run the beginning of the same episode of each task in all WAYS.

    Args:
        tasks: their names.
        seed: index into the split.
        split: of the scene seeds.

    Returns:
        By task and way, a digest of all pictures, depths and states of the episode's first frames.
    """
    found: dict[str, dict[str, str]] = {}
    for task in tqdm(tasks, desc="determinism", unit="task"):
        actions, digest = expert_actions(task, seed, split)
        found[task] = {"here": digest, "here again": digest_alone(task, seed, split, actions)}
        with process_pool(1) as pool:
            found[task]["another process"] = pool.submit(digest_alone, task, seed, split, actions).result()
        for way, asynchronous in (("sync vector", False), ("async vector", True)):
            found[task][way] = digest_in_vector(task, seed, split, actions, asynchronous)
    return found


class _Digest(Observer):
    """Takes in all that is seen in an episode."""

    def __init__(self) -> None:
        self._sha256 = hashlib.sha256()

    def begin(self, env: LlakeySimEnv, observation: Mapping[str, Any]) -> None:
        self.step(observation)

    def step(self, observation: Mapping[str, Any]) -> None:
        _add(self._sha256, observation)

    def read(self) -> str:
        return self._sha256.hexdigest()


def expert_actions(task: str, seed: int, split: str) -> tuple[np.ndarray, str]:
    """The expert's first actions (N, 9) in an episode, and the digest of what was seen on the way."""
    env, digest = LlakeySimEnv(task, split, episode_length=_ACTIONS), _Digest()
    episode = run_episode(env, Expert(), seed, [digest])
    env.close()
    return np.array(episode.actions, dtype=np.float32), digest.read()


def digest_alone(task: str, seed: int, split: str, actions: np.ndarray) -> str:
    """What actions (N, 9) show in an environment that has seen another episode before."""
    env, digest = LlakeySimEnv(task, split, episode_length=len(actions)), _Digest()
    env.reset(seed=seed + 1)
    env.step(actions[0])
    run_episode(env, Replay(actions.tolist(), [""] * len(actions)), seed, [digest])
    env.close()
    return digest.read()


def digest_in_vector(task: str, seed: int, split: str, actions: np.ndarray, asynchronous: bool) -> str:
    """What actions (N, 9) show in the second row of a vector environment."""
    vector: Any = LlakeySimConfig(task=task, split=split).create_envs(2, use_async_envs=asynchronous)[task][0]
    digest = hashlib.sha256()
    _add(digest, _row(vector.reset(seed=[seed + 1, seed])[0], 1))
    for action in actions:
        _add(digest, _row(vector.step(np.stack((action, action)))[0], 1))
    vector.close()
    return digest.hexdigest()


def _row(observation: Any, index: int) -> Any:
    if isinstance(observation, Mapping):
        return {key: _row(value, index) for key, value in observation.items()}
    return observation[index]


def _add(digest: Any, observation: Any) -> None:
    """Take in all arrays of an observation, by name."""
    if isinstance(observation, Mapping):
        for key in sorted(observation):
            digest.update(key.encode())
            _add(digest, observation[key])
    else:
        digest.update(np.ascontiguousarray(observation).tobytes())
