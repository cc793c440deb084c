"""One task's scene in motion: the model, the state of an episode, and what tasks may ask and set."""

from __future__ import annotations

import copy
import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from lerobot_llakey.bounds import require_count
from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.arm.kinematics import Kinematics
from lerobot_llakey.sim.arm.panda import HOME_JOINTS, Robot
from lerobot_llakey.sim.arm.planning import Held, Planner
from lerobot_llakey.sim.motion import Motion
from lerobot_llakey.sim.mujoco_poses import body_pose, site_pose, wxyz
from lerobot_llakey.sim.perturbations.registry import Disturbance, make_disturbance
from lerobot_llakey.sim.scene import TIMESTEP, base_spec, vary_look
from lerobot_llakey.sim.tasks.base import Task

Colour = tuple[float, float, float]

_SETTLE_SECONDS = 0.4
_VARIED = ("geom_rgba", "geom_size", "body_pos", "body_quat", "light_pos", "light_diffuse")


class World:
    """A task's scene.

    The model is compiled once; :meth:`reset` brings back everything that an episode may change, then lets the task
    place and paint its bodies, so that a seed alone determines the scene.

    Args:
        task: what to build and judge.
        detailed: whether the human's camera sees the robot's detailed meshes; they cost time to load and draw.
    """

    def __init__(self, task: Task, detailed: bool = False) -> None:
        self.task, self.detailed = task, detailed
        # A copy, since episodes paint and place things in the model itself.
        self.model: mujoco.MjModel = copy.copy(_compiled(type(task), detailed))
        self.data = mujoco.MjData(self.model)
        self.robot = Robot(self.model)
        self.kinematics = Kinematics(self.model, self.robot)
        self.motion = Motion(self, Planner(self.kinematics, self.robot))
        self.rng = np.random.default_rng(0)
        self.seed = 0
        self.disturbance: Disturbance | None = None
        self._pristine = {name: getattr(self.model, name).copy() for name in _VARIED}
        self._observer: Callable[[], None] | None = None
        self._observer_steps = 1
        self._steps = 0

    def reset(self, seed: int, variation: int | None = None, disturbance: str | None = None) -> None:
        """Build the episode of a scene seed, at rest.

        Args:
            seed: determines the scene completely.
            variation: the task's variation; drawn from the seed where None.
            disturbance: out of :data:`~lerobot_llakey.sim.perturbations.registry.DISTURBANCES`, timed by the seed and
                the task; or None.

        Raises:
            LlakeyError: if the variation is out of range, or the disturbance unknown.
        """
        count = self.task.variations
        if variation is not None:
            require_count(f"the variation of {self.task.name}", variation, 0, count - 1)
        self.seed = seed
        self.rng = np.random.default_rng(seed)
        # The name as well: one seed stands for a scene of each task, and their events are not to strike in step.
        moment = np.random.default_rng((seed, 1, *self.task.name.encode()))
        self.disturbance = make_disturbance(disturbance, moment) if disturbance else None
        drawn = int(self.rng.integers(count))
        for name, value in self._pristine.items():
            getattr(self.model, name)[:] = value
        mujoco.mj_resetData(self.model, self.data)
        vary_look(self.model, self.rng)
        self.robot.set_joints(self.data, HOME_JOINTS)
        self.task.reset(self, drawn if variation is None else int(variation))
        mujoco.mj_forward(self.model, self.data)
        self._steps = 0
        self.advance(_SETTLE_SECONDS)

    def observe(self, callback: Callable[[], None] | None, fps: float = 10.0) -> None:
        """Call ``callback`` at ``fps`` simulated frames a second from now on; None stops it."""
        self._observer, self._observer_steps = callback, max(1, round(1 / (fps * TIMESTEP)))
        self._steps = 0

    @contextmanager
    def unobserved(self) -> Iterator[None]:
        """Simulate without the observer, for what will be taken back."""
        observer, steps = self._observer, self._steps
        self._observer = None
        try:
            yield
        finally:
            self._observer, self._steps = observer, steps

    def act(self, target: Pose, gripper_open: bool, ignore_collision: bool) -> None:
        """Carry out one keyframe action, disturbed where the episode has a disturbance.

        Args:
            target: pose of the tool centre point in the base frame.
            gripper_open: state of the gripper afterwards.
            ignore_collision: whether the path may touch things.

        Raises:
            PlanningError: if there is no path; nothing has moved then.
        """
        if self.disturbance is None:
            self.motion.execute(target, gripper_open, ignore_collision)
        else:
            self.disturbance.execute(self, target, gripper_open, ignore_collision)

    def advance(self, seconds: float) -> None:
        """Simulate for a while with the present targets."""
        for _ in range(max(1, round(seconds / TIMESTEP))):
            self.step()

    def step(self) -> None:
        """Simulate one time step."""
        self.task.before_step(self)
        mujoco.mj_step(self.model, self.data)
        self._steps += 1
        if self._observer is not None and self._steps % self._observer_steps == 0:
            self._observer()

    def warnings(self) -> list[str]:
        """What MuJoCo has found wrong since it was last asked: it goes on from a reset state, or with less contacts."""
        counts = self.data.warning.number
        found = [mujoco.mjtWarning(int(kind)).name.removeprefix("mjWARN_") for kind in np.flatnonzero(counts)]
        counts[:] = 0
        return found

    # What tasks ask.

    @property
    def tool(self) -> Pose:
        """Pose of the tool centre point in the base frame."""
        return self.robot.tcp_pose(self.data)

    @property
    def gripper_closed(self) -> bool:
        """Whether the gripper was last told to close."""
        return bool(self.data.ctrl[self.robot.finger_actuators[0]] < 0.5 * self.robot.open_target)

    def state(self) -> np.ndarray:
        """(15,) float32 robot state of the data contract."""
        tool = self.tool
        parts = (tool.position, tool.quaternion, [self.robot.opening(self.data)], self.robot.joints(self.data))
        return np.concatenate(parts).astype(np.float32)

    def velocity(self) -> np.ndarray:
        """(8,) float32 velocity of the data contract."""
        return self.robot.velocity(self.data).astype(np.float32)

    def pose(self, body: str) -> Pose:
        """Pose of a body's frame in the base frame."""
        return body_pose(self.data, self.model.body(body).id)

    def site(self, name: str) -> Pose:
        """Pose of a site in the base frame."""
        return site_pose(self.data, self.model.site(name).id)

    def joint(self, name: str) -> float:
        """Value of a hinge (radians) or slide (metres) joint."""
        return float(self.data.joint(name).qpos[0])

    def held_bodies(self) -> set[str]:
        """Names of the bodies that both fingertips press on."""
        if not self.gripper_closed:
            return set()
        touched: list[set[int]] = [set(), set()]
        for first, second in self.data.contact.geom:
            for pad, bodies in zip(self.robot.pads, touched, strict=True):
                if pad in (first, second):
                    bodies.add(int(self.model.geom_bodyid[second if pad == first else first]))
        return {self.model.body(body).name for body in touched[0] & touched[1]}

    def holds(self, body: str) -> bool:
        """Whether both fingertips press on a body."""
        return body in self.held_bodies()

    def carried(self) -> list[Held]:
        """Free bodies in the gripper, as the planner moves them along."""
        tool = self.tool.inverse()
        carried = []
        for name in self.held_bodies():
            body = self.model.body(name)
            joint = self.model.joint(body.jntadr[0]) if body.jntnum[0] else None
            if joint is not None and joint.type[0] == mujoco.mjtJoint.mjJNT_FREE:
                carried.append(Held(body.id, int(joint.qposadr[0]), tool @ self.pose(name)))
        return carried

    # What tasks set at the start of an episode.

    def place(self, body: str, pose: Pose) -> None:
        """Put a free body (its joint) or a fixed one (its frame in the world) somewhere."""
        handle = self.model.body(body)
        if handle.jntnum[0] and self.model.joint(handle.jntadr[0]).type[0] == mujoco.mjtJoint.mjJNT_FREE:
            address = int(self.model.joint(handle.jntadr[0]).qposadr[0])
            self.data.qpos[address : address + 7] = (*pose.position, *wxyz(pose.quaternion))
        else:
            handle.pos[:], handle.quat[:] = pose.position, wxyz(pose.quaternion)

    def set_joint(self, name: str, value: float) -> None:
        """Set a hinge (radians) or slide (metres) joint."""
        self.data.joint(name).qpos[0] = value

    def paint(self, geom: str, colour: Colour) -> None:
        """Colour a geom with RGB in 0..1, keeping its opacity."""
        self.model.geom(geom).rgba[:3] = colour


@functools.cache
def _compiled(task: type[Task], detailed: bool) -> mujoco.MjModel:
    spec = base_spec(detailed)
    task().build(spec)
    return spec.compile()
