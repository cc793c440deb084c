"""Recording an expert's episode: first the motion alone, then pictures of only those frames that are asked for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import DOWN, nearest_sign
from lerobot_llakey.keyframes.rest import discover_keyframes
from lerobot_llakey.labels import Interruption, Labels, label
from lerobot_llakey.sim.cameras import RGBD, CameraRig
from lerobot_llakey.sim.expert import ExpertStep, demonstrate
from lerobot_llakey.sim.perturbations.registry import make_perturbation
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks.base import Waypoint

FPS = 10
"""Frames a second of demonstrations."""
_REACHED_WITHIN = 0.7
"""Seconds before the end of an action, rest included, within which its keyframe lies."""


@dataclass(frozen=True)
class Episode:
    """A recorded episode, without pictures.

    Attributes:
        states: (T, 15) float32, see schema.SIM_STATE_NAMES; quaternions without jumps.
        velocities: (T, 8) float32, see schema.SIM_VELOCITY_NAMES.
        qpos: (T, nq) the scene's configuration, from which pictures are rendered.
        keyframes: discovered from the states alone; empty where fewer than two frames were recorded.
        waypoints: what the expert went for, one a segment where keyframes_match.
        keyframes_match: whether each waypoint has exactly one discovered keyframe, at its end, the gripper as meant.
        success: whether the task's oracle was satisfied at the end.
        task: name of the task.
        description: skill instruction.
        seed: scene seed.
        variation: of the task.
        sequence: action sequence of the task.
        fps: frames a second.
        gripper_open: what the gripper was commanded to be at the end of each action.
        failures: why the arm did not move, where it did not.
        interruptions: the actions that a disturbance kept from ending as meant.
    """

    states: np.ndarray
    velocities: np.ndarray
    qpos: np.ndarray
    keyframes: list[int]
    waypoints: list[Waypoint]
    keyframes_match: bool
    success: bool
    task: str
    description: str
    seed: int
    variation: int
    sequence: int
    fps: float = FPS
    gripper_open: list[bool] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    interruptions: list[Interruption] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.states)

    @property
    def usable(self) -> bool:
        """Whether it is fit for training: the task was done and the keyframes are the waypoints."""
        return self.success and self.keyframes_match

    def labels(self) -> Labels:
        """Action, instructions and keyframe columns of every frame.

        Raises:
            LlakeyError: if the keyframes do not match the waypoints.
        """
        return label(
            self.states,
            self.keyframes,
            [waypoint.instruction for waypoint in self.waypoints],
            [waypoint.ignore_collision for waypoint in self.waypoints],
            self.gripper_open,
            self.interruptions,
        )

    def origin(self) -> dict[str, np.ndarray | str]:
        """Columns that say which scene this is."""
        return {
            schema.EPISODE_SEED: np.array([self.seed]),
            schema.EPISODE_VARIATION: np.array([self.variation]),
            schema.EPISODE_SEQUENCE: np.array([self.sequence]),
            schema.EPISODE_TASK: self.task,
        }


def record(
    simulation: Simulation, seed: int, variation: int | None = None, fps: float = FPS, disturbance: str | None = None
) -> Episode:
    """Let the expert do the task of a scene seed.

    Args:
        simulation: reset here; it keeps the scene's look, which :func:`render_frames` needs, until its next reset.
        seed: scene seed.
        variation: the task's variation; drawn from the seed where None.
        fps: frames a second.
        disturbance: as :func:`~lerobot_llakey.sim.perturbations.registry.make_perturbation` takes it, or None.
    """
    world, clock = simulation.world, simulation.clock
    simulation.reset(seed, variation, make_perturbation(disturbance or "", seed, simulation.task.name))
    states: list[np.ndarray] = []
    velocities: list[np.ndarray] = []
    configurations: list[np.ndarray] = []
    times: list[float] = []

    def take() -> None:
        states.append(world.state(states[-1] if states else None))
        velocities.append(world.velocity())
        configurations.append(world.data.qpos.copy())
        times.append(float(world.data.time))

    clock.observe(take, fps)
    take()
    steps: list[ExpertStep] = []
    ends: list[int] = []
    opened: list[bool] = []
    interruptions: list[Interruption] = []
    for step in demonstrate(simulation):
        steps.append(step)
        ends.append(len(states) - 1)
        opened.append(not simulation.world.gripper_closed)
        struck = simulation.perturbation.time if simulation.perturbation is not None else None
        if struck is not None:
            frame = int(np.searchsorted(times, struck))
            meant = waypoint_action(step.waypoint, states[-1])
            interruptions.append(Interruption(len(steps) - 1, frame, meant, disturbance or ""))
    clock.observe(None)
    trajectory = np.stack(states)
    keyframes: list[int] = []
    if len(trajectory) > 1:
        keyframes = discover_keyframes(trajectory[:, schema.HAND_DIM :], trajectory[:, schema.GRIPPER], fps)
    waypoints = [step.waypoint for step in steps]
    for interruption in interruptions:
        keyframes = _without_event(keyframes, ends, interruption.segment)
    task = simulation.task
    return Episode(
        states=trajectory,
        velocities=np.stack(velocities),
        qpos=np.stack(configurations),
        keyframes=keyframes,
        waypoints=waypoints,
        keyframes_match=_match(keyframes, ends, waypoints, opened, fps, interruptions),
        success=bool(steps) and bool(steps[-1].success),
        task=task.name,
        description=task.description,
        seed=seed,
        variation=int(task.variation),
        sequence=int(task.sequence),
        fps=fps,
        gripper_open=opened,
        failures=[step.failure for step in steps if step.failure],
        interruptions=interruptions,
    )


def waypoint_action(waypoint: Waypoint, state: np.ndarray | None = None) -> np.ndarray:
    """Action (9,) float32 that asks for a waypoint, its quaternion of the sign nearest to the present state's."""
    pose = waypoint.pose
    quaternion = nearest_sign(pose.quaternion, DOWN if state is None else state[schema.QUATERNION])
    return np.array((*pose.position, *quaternion, waypoint.gripper_open, waypoint.ignore_collision), dtype=np.float32)


def _without_event(keyframes: list[int], ends: list[int], segment: int) -> list[int]:
    """The keyframes with only the last one of the action that an event struck: what it did besides was not meant."""
    begin = ends[segment - 1] + 1 if segment else 0
    during = [frame for frame in keyframes if begin < frame <= ends[segment] + 1]
    return sorted(set(keyframes) - set(during[:-1]))


def _match(
    keyframes: list[int],
    ends: list[int],
    waypoints: Sequence[Waypoint],
    opened: Sequence[bool],
    fps: float,
    interruptions: Sequence[Interruption],
) -> bool:
    if len(keyframes) != len(ends) or not ends:
        return False
    frames = np.array(keyframes)
    # The next action may start before the robot has settled, where it moves the gripper alone.
    on_time = (frames <= np.array(ends) + 1) & (frames >= np.array(ends) - _REACHED_WITHIN * fps)
    gripper = np.array([waypoint.gripper_open for waypoint in waypoints]) == opened
    for cut in interruptions:
        # Cut short, an action need not end as it was meant to; what follows it must tell how to go on.
        gripper[cut.segment] |= cut.segment < len(ends) - 1
    return bool(on_time.all() and gripper.all())


def render_frames(
    simulation: Simulation, rig: CameraRig, episode: Episode, frames: Iterable[int]
) -> Iterator[tuple[int, dict[str, RGBD]]]:
    """Pictures of some frames of the episode that the simulation recorded last.

    Args:
        simulation: as :func:`record` left it.
        rig: cameras of the world's model.
        episode: what was recorded.
        frames: indices of frames.

    Yields:
        The frame's index and its pictures by camera.

    Raises:
        LlakeyError: if it was reset for another scene since.
    """
    task, seed = simulation.task.name, simulation.seed
    if (task, seed) != (episode.task, episode.seed):
        raise LlakeyError(
            f"Expected the world of {episode.task} seed {episode.seed}, got {task} seed {seed}; "
            "render before recording the next episode."
        )
    model = simulation.world.model
    scratch = mujoco.MjData(model)
    pictures: dict[str, RGBD] = {}
    for frame in frames:
        scratch.qpos[:] = episode.qpos[frame]
        mujoco.mj_kinematics(model, scratch)
        mujoco.mj_comPos(model, scratch)
        mujoco.mj_camlight(model, scratch)
        pictures = rig.render_all(scratch, pictures)
        yield frame, pictures


def frame_columns(pictures: Mapping[str, RGBD]) -> dict[str, np.ndarray]:
    """Pictures under the contract's names: RGB uint8 (H, W, 3), depth uint16 (H, W, 1) in millimetres, calibration."""
    columns: dict[str, np.ndarray] = {}
    for camera, picture in pictures.items():
        columns[schema.image_key(camera)] = picture.rgb
        columns[schema.depth_key(camera)] = np.rint(picture.depth).clip(0, 65535).astype(np.uint16)[..., None]
        columns[schema.intrinsics_key(camera)] = picture.intrinsics
        columns[schema.extrinsics_key(camera)] = picture.pose
    return columns
