"""Running a saved policy through single episodes of the simulator, with all that happened kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import torch
from lerobot.configs.policies import PreTrainedConfig
from lerobot.envs.utils import preprocess_observation
from lerobot.policies.factory import make_policy, make_pre_post_processors
from lerobot.policies.pretrained import PreTrainedPolicy

from lerobot_llakey import schema
from lerobot_llakey.files import reading
from lerobot_llakey.saved.folder import inspect_checkpoint
from lerobot_llakey.sim.configuration_llakey_sim import LlakeySimConfig
from lerobot_llakey.sim.env import LlakeySimEnv
from lerobot_llakey.sim.recorder import waypoint_action
from lerobot_llakey.sim.tasks.base import Waypoint
from lerobot_llakey.sim.text_codes import decode_text

Processor = Callable[[Any], Any]
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


class Actor(Protocol):
    """Whoever acts in an episode."""

    def reset(self) -> None:
        """Forget the last episode."""

    def act(self, env: LlakeySimEnv, observation: Mapping[str, Any]) -> tuple[np.ndarray, str]:
        """Action (9,) for one unbatched observation of the environment, and the basic instruction behind it."""


class Expert:
    """The scripted demonstrator of the environment's task; once it sees nothing left to do it stays where it is."""

    def reset(self) -> None:
        """Nothing to forget: it looks at the present state alone."""

    def act(self, env: LlakeySimEnv, observation: Mapping[str, Any]) -> tuple[np.ndarray, str]:
        """The next waypoint of the task's plan."""
        waypoint = env.expert_waypoint() or Waypoint(env.world.tool, not env.world.gripper_closed, True, "")
        return waypoint_action(waypoint, observation["agent_pos"]), waypoint.instruction


@dataclass(frozen=True)
class Agent:
    """A policy with its processors, as saved together.

    Attributes:
        policy: in evaluation mode.
        preprocessor: observation with batch dimension -> batch.
        postprocessor: actions -> actions.
        env_preprocessor: what LeRobot runs before the preprocessor: the environment's own.
    """

    policy: PreTrainedPolicy
    preprocessor: Processor
    postprocessor: Processor
    env_preprocessor: Processor = field(default_factory=lambda: LlakeySimConfig().get_env_processors()[0])

    @staticmethod
    def load(
        path: str | Path, oracle: bool = False, overrides: Sequence[str] = (), dataset_meta: Any | None = None
    ) -> Agent:
        """Load a checkpoint folder or a Hub repository.

        Args:
            path: what LeRobot calls ``--policy.path``.
            oracle: let the expert's instructions, which the environment must give, take the command policy's place.
            overrides: other settings, each as on a command line: ``--repeat_threshold=5``.
            dataset_meta: of the dataset whose frames it will be given, in place of the simulator's.

        Raises:
            MissingFileError: if nothing is there.
            LlakeyError: if it is broken, or names what no checkpoint may.
        """
        folder = inspect_checkpoint(path)
        with reading(folder, "checkpoint"):
            return _load(folder, oracle, overrides, dataset_meta)

    def reset(self) -> None:
        """Forget the last episode."""
        self.policy.reset()

    def act(self, env: LlakeySimEnv, observation: Mapping[str, Any]) -> tuple[np.ndarray, str]:
        """Action (9,) for one unbatched observation of the environment, and the basic instruction behind it."""
        action = self.act_on(self.batch(env.task_description, observation))
        instructions = getattr(self.policy, "last_instructions", None) or [""]
        return action, instructions[0]

    def batch(self, task: str, observation: Mapping[str, Any]) -> dict[str, Any]:
        """What the policy is given for one unbatched observation: a batch of one row.

        Args:
            task: the skill instruction.
            observation: of the environment.
        """
        arrays = {key: _with_batch(value) for key, value in observation.items()}
        batch: dict[str, Any] = preprocess_observation(arrays)
        batch[schema.TASK] = [task]
        processed: dict[str, Any] = self.preprocessor(self.env_preprocessor(batch))
        return processed

    def act_on(self, batch: dict[str, Any]) -> np.ndarray:
        """Action (9,) for a batch of one row."""
        with torch.inference_mode():
            action: np.ndarray = self.postprocessor(self.policy.select_action(batch))[0].cpu().numpy()
        return action


def _load(folder: Path, oracle: bool, overrides: Sequence[str], dataset_meta: Any | None) -> Agent:
    config = PreTrainedConfig.from_pretrained(folder, cli_overrides=list(overrides))
    config.pretrained_path = folder
    if oracle and hasattr(config, "commander"):  # an action policy alone reads the oracle by itself
        config.commander = "oracle"
    policy = make_policy(config, ds_meta=dataset_meta, env_cfg=None if dataset_meta else LlakeySimConfig())
    preprocessor, postprocessor = make_pre_post_processors(
        config,
        pretrained_path=str(folder),
        preprocessor_overrides={"device_processor": {"device": str(config.device)}},
    )
    return Agent(policy.eval(), preprocessor, postprocessor)


def run_episode(
    env: LlakeySimEnv, agent: Actor, seed: int, on_instruction: Callable[[str], None] | None = None
) -> Episode:
    """Run one episode.

    Args:
        env: the task's environment.
        agent: who acts.
        seed: index of the scene within the environment's split.
        on_instruction: told each basic instruction before it is acted on.
    """
    agent.reset()
    observation, info = env.reset(seed=seed)
    instructions: list[str] = []
    failures: list[str] = []
    oracle: list[str] = []
    actions: list[list[float]] = []
    over = False
    while not over:
        proposed, instruction = agent.act(env, observation)
        action = np.asarray(proposed, dtype=np.float32)
        if on_instruction is not None:
            on_instruction(instruction)
        oracle.append(decode_text(observation.get(ORACLE_KEY, ())))
        observation, _, terminated, truncated, info = env.step(action)
        instructions.append(instruction)
        failures.append(info["failure"])
        actions.append(action.tolist())
        over = terminated or truncated
    return Episode(
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


def _with_batch(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _with_batch(item) for key, item in value.items()}
    return np.asarray(value)[None]
