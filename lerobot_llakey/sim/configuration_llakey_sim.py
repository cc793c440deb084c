"""``--env.type=llakey_sim``: LeRobot's configuration of the simulator."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import Any

import gymnasium as gym
from lerobot.configs import FeatureType, PolicyFeature
from lerobot.envs.configs import EnvConfig
from lerobot.envs.utils import _LazyAsyncVectorEnv, freeze_after_episode_end
from lerobot.processor import PolicyProcessorPipeline

from lerobot_llakey import schema
from lerobot_llakey.bounds import require_count
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.processes import share_imports
from lerobot_llakey.sim.settings import MAX_STEPS, check_settings
from lerobot_llakey.sim.text_codes import OracleTextStep

SUITE = "llakey_sim"


@EnvConfig.register_subclass(SUITE)
@dataclass
class LlakeySimConfig(EnvConfig):
    """Settings of the simulator.

    Attributes:
        task: task names separated by commas, or ``all``.
        fps: frames a second of the videos that lerobot-eval writes, one frame for each keyframe action.
        split: which range of scene seeds episodes come from: train, val or test.
        image_size: height and width in pixels of the four RGB-D cameras.
        episode_length: keyframe actions after which an episode ends.
        oracle_instructions: add the expert's instruction from the present state to each observation.
        render_size: height and width in pixels of the pictures made for people.
        detailed: show the robot's detailed meshes in pictures made for people.
        disturbance: unforeseen event that strikes once an episode (drop, block, shift or empty_grasp), or
            execution_noise: a hand that ends beside its target; none where empty.
        features: what an observation holds, derived from image_size; the state is ordered as schema.SIM_STATE_NAMES.
        features_map: names of the features in LeRobot's observations.

    Raises:
        LlakeyError: if a setting is unknown or out of range, or several tasks are to share a policy between threads.
    """

    task: str | None = "all"
    fps: int = 2
    split: str = "test"
    image_size: int = schema.IMAGE_SIZE
    episode_length: int = MAX_STEPS
    oracle_instructions: bool = False
    render_size: tuple[int, int] = (480, 640)
    detailed: bool = False
    disturbance: str = ""
    features: dict[str, PolicyFeature] = field(default_factory=dict)
    features_map: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.max_parallel_tasks != 1:
            raise LlakeyError(
                f"Expected env.max_parallel_tasks=1, got {self.max_parallel_tasks!r}: several tasks would share "
                "one policy's state between threads; raise eval.batch_size instead."
            )
        check_settings(
            "env.",
            self.task,
            self.split,
            self.image_size,
            self.episode_length,
            self.oracle_instructions,
            self.render_size,
            self.fps,
            self.detailed,
            self.disturbance,
        )
        size = self.image_size
        self.features = {
            schema.ACTION: PolicyFeature(FeatureType.ACTION, (schema.ACTION_DIM,)),
            "agent_pos": PolicyFeature(FeatureType.STATE, (len(schema.SIM_STATE_NAMES),)),
            "velocity": PolicyFeature(FeatureType.STATE, (len(schema.SIM_VELOCITY_NAMES),)),
            "step": PolicyFeature(FeatureType.STATE, (1,)),
        }
        self.features_map = {
            schema.ACTION: schema.ACTION,
            "agent_pos": schema.STATE,
            "velocity": schema.VELOCITY,
            "step": schema.STEP,
        }
        for camera in schema.CAMERAS:
            self.features[f"pixels/{camera}"] = PolicyFeature(FeatureType.VISUAL, (size, size, 3))
            self.features_map[f"pixels/{camera}"] = schema.image_key(camera)
            self.features[f"images.{camera}_depth"] = PolicyFeature(FeatureType.VISUAL, (size, size, 1))
            self.features_map[f"images.{camera}_depth"] = schema.depth_key(camera)
            for calibration, names, key in (
                ("camera_intrinsics", schema.INTRINSICS_NAMES, schema.intrinsics_key),
                ("camera_extrinsics", schema.POSE_NAMES, schema.extrinsics_key),
            ):
                self.features[f"{calibration}.{camera}"] = PolicyFeature(FeatureType.STATE, (len(names),))
                self.features_map[f"{calibration}.{camera}"] = key(camera)

    @property
    def gym_kwargs(self) -> dict[str, Any]:
        """Arguments of :class:`lerobot_llakey.sim.env.LlakeySimEnv` beside the task."""
        return {
            "split": self.split,
            "image_size": self.image_size,
            "episode_length": self.episode_length,
            "oracle_instructions": self.oracle_instructions,
            "render_size": tuple(self.render_size),
            "render_fps": self.fps,
            "detailed": self.detailed,
            "disturbance": self.disturbance,
        }

    def get_env_processors(self) -> tuple[PolicyProcessorPipeline, PolicyProcessorPipeline]:
        """What comes between observations and a policy's preprocessor, and between its actions and the environment."""
        return PolicyProcessorPipeline(steps=[OracleTextStep()]), PolicyProcessorPipeline(steps=[])

    def create_envs(self, n_envs: int, use_async_envs: bool = False) -> dict[str, dict[int, gym.vector.VectorEnv]]:
        """One vector environment of ``n_envs`` copies for each task: ``{task: {0: VectorEnv}}``.

        Each task is a suite of its own, so that lerobot-eval reports it by name.

        Raises:
            LlakeyError: if there is to be less than one copy.
        """
        require_count("eval.batch_size", n_envs, 1)
        # MuJoCo is needed from here on only, so that policies load without it.
        from lerobot_llakey.sim.env import LlakeySimEnv
        from lerobot_llakey.sim.tasks import parse_tasks

        envs: dict[str, dict[int, gym.vector.VectorEnv]] = {}
        for task in parse_tasks(self.task or ""):
            makers = [functools.partial(LlakeySimEnv, task, **self.gym_kwargs) for _ in range(n_envs)]
            if use_async_envs and n_envs > 1:
                share_imports()
                probe = makers[0]()
                vector = _LazyAsyncVectorEnv(makers, probe.observation_space, probe.action_space, probe.metadata)
            else:
                vector = gym.vector.SyncVectorEnv(
                    [freeze_after_episode_end(maker) for maker in makers],
                    autoreset_mode=gym.vector.AutoresetMode.NEXT_STEP,
                )
            envs[task] = {0: vector}
        return envs
