"""One episode: an actor acts in an environment, what happens is kept, and observers see it go by."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from lerobot.utils.random_utils import set_seed

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.reporting.tables import markdown_table
from lerobot_llakey.rollout.actors import Actor
from lerobot_llakey.sim.env import LlakeySimEnv
from lerobot_llakey.sim.text_codes import decode_text

ORACLE_KEY = "oracle_instruction"
"""Where an observation of the environment holds the expert's instruction."""


@dataclass(frozen=True)
class Episode:
    """What a policy did with one scene.

    Attributes:
        task: name of the task.
        description: its skill instruction.
        seed: index of the scene within its split.
        variation: variation of the task.
        sequence: action sequence that the scene asks for.
        success: whether the oracle was satisfied.
        instructions: basic instruction behind each action; empty strings for policies without any.
        failures: "" for each action that moved the arm, else why it did not.
        oracle: the expert's instruction before each action; empty strings where the environment does not give it.
        actions: each action (9,), as numbers that survive JSON to the last bit.
        disturbed: whether a disturbance struck.
    """

    task: str
    description: str
    seed: int
    variation: int
    sequence: int
    success: bool
    instructions: list[str] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    oracle: list[str] = field(default_factory=list)
    actions: list[list[float]] = field(default_factory=list)
    disturbed: bool = False


class Observer:
    """Sees an episode go by, as a subscriber of openpi's runtime does; what is not overridden does nothing."""

    def begin(self, env: LlakeySimEnv, observation: Mapping[str, Any]) -> None:
        """The scene is set, and nobody has acted yet."""

    def decide(self, instruction: str) -> None:
        """The actor has decided, by this basic instruction; its action is carried out next."""

    def step(self, observation: Mapping[str, Any]) -> None:
        """An action was carried out."""

    def end(self, episode: Episode) -> None:
        """The episode is over."""


def run_episode(env: LlakeySimEnv, actor: Actor, seed: int, observers: Iterable[Observer] = ()) -> Episode:
    """Run one episode; the scene's seed fixes everything random in it.

    Args:
        env: the task's environment.
        actor: who acts.
        seed: index of the scene within the environment's split.
        observers: told what happens, while it happens.
    """
    observers = list(observers)
    scene = schema.scene_seed(env.split, seed)
    set_seed(scene)
    actor.reset(scene)
    observation, info = env.reset(seed=seed)
    for observer in observers:
        observer.begin(env, observation)
    instructions: list[str] = []
    failures: list[str] = []
    oracle: list[str] = []
    actions: list[list[float]] = []
    over = False
    while not over and (decision := actor.act(env, observation)) is not None:
        action, instruction = np.asarray(decision[0], dtype=np.float32), decision[1]
        for observer in observers:
            observer.decide(instruction)
        oracle.append(decode_text(observation.get(ORACLE_KEY, ())))
        observation, _, terminated, truncated, info = env.step(action)
        for observer in observers:
            observer.step(observation)
        instructions.append(instruction)
        failures.append(info["failure"])
        actions.append(action.tolist())
        over = terminated or truncated
    episode = Episode(
        env.task,
        env.task_description,
        seed,
        info["variation"],
        info["sequence"],
        info["is_success"],
        instructions,
        failures,
        oracle,
        actions,
        info["disturbed"],
    )
    for observer in observers:
        observer.end(episode)
    return episode


def success_table(episodes: Sequence[Episode]) -> str:
    """Episodes, successes and mean number of actions of each task, and their average over tasks.

    Raises:
        LlakeyError: if there are no episodes.
    """
    if not episodes:
        raise LlakeyError("Expected at least one episode, got none; raise --num_episodes.")
    rows, rates = [], []
    for task in dict.fromkeys(episode.task for episode in episodes):
        of_task = [episode for episode in episodes if episode.task == task]
        solved = [episode for episode in of_task if episode.success]
        rates.append(len(solved) / len(of_task))
        actions = sum(len(episode.instructions) for episode in of_task) / len(of_task)
        rows.append([task, str(len(of_task)), str(len(solved)), f"{100 * rates[-1]:.0f} %", f"{actions:.1f}"])
    rows.append(["average", str(len(episodes)), "", f"{100 * sum(rates) / len(rates):.0f} %", ""])
    return markdown_table(["task", "episodes", "solved", "success", "actions"], rows)
