"""``llakey_sim`` as a Gymnasium environment: one step is one keyframe action."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from typing import Any

import gymnasium as gym
import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.bounds import require_count, require_number
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.arm.planning import PlanningError
from lerobot_llakey.sim.cameras import RGBD, CameraRig
from lerobot_llakey.sim.perturbations.registry import make_perturbation
from lerobot_llakey.sim.settings import MAX_STEPS, check_settings
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.spaces import action_space, checked_action, observation_space, require_units
from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.tasks.base import Waypoint
from lerobot_llakey.sim.text_codes import encode_text
from lerobot_llakey.sim.world import World

_LOG = logging.getLogger(__name__)
_HALF = 0.5
_OPTIONS = ("variation", "lerobot_")
"""Beginnings of what may stand in the options of a reset; LeRobot adds its own."""


class LlakeySimEnv(gym.Env):
    """A task in the simulator.

    An action is the contract's keyframe (9,): the arm plans and moves there, then the gripper opens or closes, and
    things come to rest. A pose that cannot be reached is a step without motion: ``info["moved"]`` is false and
    ``info["failure"]`` says why; ``info["disturbed"]`` says whether a disturbance has struck. Reward is 1 at the step
    that solves the task.

    The scene and its OpenGL context are made at the first reset, in the process that uses them.

    Args:
        task: name of the task.
        split: range of scene seeds: train, val or test.
        image_size: height and width in pixels of the cameras.
        episode_length: actions after which an episode is cut off.
        oracle_instructions: add the expert's instruction to the observation, as the code points of
            :func:`lerobot_llakey.sim.text_codes.encode_text`.
        render_size: height and width in pixels of :meth:`render`.
        render_fps: frames a second of videos with one frame an action.
        detailed: show the robot's detailed meshes to people.
        disturbance: unforeseen event that strikes once an episode or ``execution_noise`` (see
            :data:`~lerobot_llakey.sim.perturbations.registry.DISTURBANCES`); none where empty.

    Raises:
        LlakeyError: if a setting is unknown or out of range.
    """

    def __init__(
        self,
        task: str,
        split: str = "test",
        image_size: int = schema.IMAGE_SIZE,
        episode_length: int = MAX_STEPS,
        oracle_instructions: bool = False,
        render_size: tuple[int, int] = (480, 640),
        render_fps: int = 2,
        detailed: bool = False,
        disturbance: str = "",
    ) -> None:
        watching = (render_size, render_fps, detailed)
        check_settings("", task, split, image_size, episode_length, oracle_instructions, *watching, disturbance)
        self._task = make_task(task)
        self.task, self.split = self._task.name, split
        self.render_mode = "rgb_array"
        self.metadata = {"render_modes": ["rgb_array"], "render_fps": render_fps}
        self._max_episode_steps = episode_length
        self._oracle_instructions = oracle_instructions
        self.disturbance = disturbance
        self._image_size, self._render_size, self._detailed = image_size, render_size, detailed
        self._simulation: Simulation | None = None
        self._rig: CameraRig | None = None
        self._pictures: Mapping[str, RGBD] = {}
        self._state: np.ndarray | None = None
        self._elapsed = 0
        self._is_running = False
        self._on_frame: Callable[[np.ndarray], None] | None = None
        self.observation_space = observation_space(image_size, oracle_instructions)
        self.action_space = action_space()

    @property
    def task_description(self) -> str:
        """The episode's skill instruction; the task's name before the first reset."""
        return self._task.description or self.task

    @property
    def simulation(self) -> Simulation:
        """The task's episodes, made at first use."""
        if self._simulation is None:
            self._simulation = Simulation(self._task, self._detailed)
        return self._simulation

    @property
    def world(self) -> World:
        """The scene's state."""
        return self.simulation.world

    @property
    def rig(self) -> CameraRig:
        """The cameras, made at first use."""
        if self._rig is None:
            self._rig = CameraRig(self.world.model, self._image_size)
        return self._rig

    @property
    def pictures(self) -> Mapping[str, RGBD]:
        """What each camera showed in the last observation; empty before the first reset."""
        return self._pictures

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Start the episode of a seed within the split; ``options["variation"]`` asks for a variation.

        Raises:
            LlakeyError: if the seed or the variation is out of range, or an option unknown.
        """
        count = len(schema.SEED_RANGES[self.split])
        if seed is not None:
            require_count("the seed", seed, 0, count - 1)
        asked = dict(options or {})
        if unknown := [name for name in asked if not str(name).startswith(_OPTIONS)]:
            raise LlakeyError(f"Expected no option but 'variation', got {unknown}; correct the options of reset().")
        super().reset(seed=None if seed is None else int(seed))
        index = int(self.np_random.integers(count)) if seed is None else int(seed)
        self.simulation.clock.observe(None)
        self._is_running = False
        scene = schema.scene_seed(self.split, index)
        perturbation = make_perturbation(self.disturbance, scene, self.task)
        self.simulation.reset(scene, asked.get("variation"), perturbation)
        self._watch()
        self._elapsed, self._is_running = 0, True
        self._pictures, self._state = {}, None  # quaternions' signs are an episode's own
        return self._observation(), self._info(self.simulation.success(), "")

    def step(self, action: np.ndarray) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Carry out one keyframe action (9,).

        Raises:
            LlakeyError: if it is no action: another shape, or not finite; or if no episode has been begun.
        """
        self._require_episode("step()")
        action = checked_action(action)
        simulation, failure = self.simulation, ""
        try:
            require_units(action)
            target = Pose(action[schema.POSITION], action[schema.QUATERNION])
            simulation.act(target, bool(action[schema.GRIPPER] > _HALF), bool(action[schema.IGNORE_COLLISION] > _HALF))
        except PlanningError as error:
            failure = error.reason
        if warnings := simulation.clock.warnings():
            _LOG.warning("Physics of %s, seed %d, went wrong: %s.", self.task, simulation.seed, ", ".join(warnings))
        self._elapsed += 1
        success = simulation.success()
        truncated = self._elapsed >= self._max_episode_steps and not success
        return self._observation(), float(success), success, truncated, self._info(success, failure)

    def render(self) -> np.ndarray:
        """(height, width, 3) uint8 picture for people.

        Raises:
            LlakeyError: if no episode has been begun.
        """
        self._require_episode("render()")
        return self.rig.render_for_people(self.world.data, *self._render_size)

    def watch(self, on_frame: Callable[[np.ndarray], None] | None, fps: float = 25.0) -> None:
        """Hand every simulated frame (height, width, 3) at ``fps`` to a callback from now on; None stops it.

        Raises:
            LlakeyError: if the rate is not above 0.
        """
        require_number("the frames a second to watch", fps, 0, open="low")
        self._on_frame, self._watch_fps = on_frame, fps
        if self._simulation is not None:
            self._watch()

    def oracle_instruction(self) -> str:
        """The instruction of :meth:`expert_waypoint`; empty where that is None."""
        waypoint = self.expert_waypoint()
        return "" if waypoint is None else waypoint.instruction

    def expert_waypoint(self) -> Waypoint | None:
        """What the expert would do next from the present state; None when it has nothing left to do.

        Raises:
            LlakeyError: if no episode has been begun.
        """
        self._require_episode("expert_waypoint()")
        waypoints = self.simulation.plan()
        return waypoints[0] if waypoints else None

    def close(self) -> None:
        """Free the scene and its OpenGL contexts; another reset makes them anew."""
        if self._rig is not None:
            self._rig.close()
        self._rig = self._simulation = None
        self._is_running = False

    def _require_episode(self, call: str) -> None:
        if not self._is_running:
            raise LlakeyError(f"Expected reset() before {call}, got no episode (none begun, or closed); call reset().")

    def _watch(self) -> None:
        callback = self._on_frame
        if callback is None:
            self.simulation.clock.observe(None)
        else:
            self.simulation.clock.observe(lambda: callback(self.render()), self._watch_fps)

    def _observation(self) -> dict[str, Any]:
        pictures = self._pictures = self.rig.render_all(self.world.data, self._pictures)
        self._state = self.world.state(self._state)
        observation: dict[str, Any] = {
            "pixels": {camera: pictures[camera].rgb for camera in schema.CAMERAS},
            "agent_pos": self._state.copy(),
            "velocity": self.world.velocity(),
            "step": np.array([self._elapsed], dtype=np.float32),
        }
        for camera, picture in pictures.items():
            observation[f"images.{camera}_depth"] = picture.depth[None]
            observation[f"camera_intrinsics.{camera}"] = picture.intrinsics
            observation[f"camera_extrinsics.{camera}"] = picture.pose
        if self._oracle_instructions:
            observation["oracle_instruction"] = encode_text(self.oracle_instruction())
        return observation

    def _info(self, success: bool, failure: str) -> dict[str, Any]:
        perturbation = self.simulation.perturbation
        return {
            "is_success": success,
            "moved": not failure,
            "failure": failure,
            "variation": int(self._task.variation),
            "sequence": int(self._task.sequence),
            "disturbed": perturbation is not None and perturbation.struck,
        }
