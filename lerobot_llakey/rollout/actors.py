"""Who acts in an episode: a saved policy, or the expert."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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

Processor = Callable[[Any], Any]
Decision = tuple[np.ndarray, str]
"""An action (9,) and the basic instruction behind it; empty for policies without any."""


class Actor(Protocol):
    """Whoever acts in an episode."""

    def reset(self, seed: int | None = None) -> None:
        """Forget the last episode, and draw from another seed where one is given."""

    def act(self, env: LlakeySimEnv, observation: Mapping[str, Any]) -> Decision | None:
        """What to do after one unbatched observation of the environment; None ends the episode."""


class Expert:
    """The scripted demonstrator of the environment's task; once it sees nothing left to do it stays where it is."""

    def reset(self, seed: int | None = None) -> None:
        """Nothing to forget: it looks at the present state alone."""

    def act(self, env: LlakeySimEnv, observation: Mapping[str, Any]) -> Decision:
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
        wording: skill instruction and the scene's action sequence -> what the policy is told; the former where None.
    """

    policy: PreTrainedPolicy
    preprocessor: Processor
    postprocessor: Processor
    env_preprocessor: Processor = field(default_factory=lambda: LlakeySimConfig().get_env_processors()[0])
    wording: Callable[[str, int], str] | None = None

    @staticmethod
    def load(
        path: str | Path,
        oracle: bool = False,
        overrides: Mapping[str, Any] | None = None,
        dataset_meta: Any | None = None,
    ) -> Agent:
        """Load a checkpoint folder or a Hub repository.

        Args:
            path: what LeRobot calls ``--policy.path``.
            oracle: let the expert's instructions, which the environment must give, take the command policy's place.
            overrides: other settings by dotted name, such as ``{"command.device": "cpu"}``.
            dataset_meta: of the dataset whose frames it will be given, in place of the simulator's.

        Raises:
            MissingFileError: if nothing is there.
            LlakeyError: if it is broken, or names what no checkpoint may.
        """
        folder = inspect_checkpoint(path)
        with reading(folder, "checkpoint"):
            return _load(folder, oracle, command_line(overrides or {}), dataset_meta)

    def reset(self, seed: int | None = None) -> None:
        """Forget the last episode, and draw from another seed where one is given."""
        reseed = getattr(self.policy, "reseed", None)
        if seed is not None and reseed is not None:
            reseed(seed)
        self.policy.reset()

    def act(self, env: LlakeySimEnv, observation: Mapping[str, Any]) -> Decision:
        """Action (9,) for one unbatched observation of the environment, and the basic instruction behind it."""
        task = env.task_description
        if self.wording is not None:
            task = self.wording(task, env.simulation.task.sequence)
        action = self.act_on(self.batch(task, observation))
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


def command_line(overrides: Mapping[str, Any]) -> list[str]:
    """A policy's settings by dotted name, as on a command line: ``{commander: oracle}`` -> ``--commander=oracle``."""
    return [f"--{name}={str(value).lower() if isinstance(value, bool) else value}" for name, value in overrides.items()]


def _load(folder: Path, oracle: bool, arguments: list[str], dataset_meta: Any | None) -> Agent:
    config = PreTrainedConfig.from_pretrained(folder, cli_overrides=arguments)
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


def _with_batch(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _with_batch(item) for key, item in value.items()}
    return np.asarray(value)[None]
