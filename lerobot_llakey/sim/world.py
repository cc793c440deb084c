"""A scene's state: the model and its data, and what tasks may ask and set."""

from __future__ import annotations

import copy
from collections.abc import Mapping

import mujoco
import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.geometry import DOWN, Pose, nearest_sign
from lerobot_llakey.sim.arm.kinematics import Kinematics
from lerobot_llakey.sim.arm.panda import Robot
from lerobot_llakey.sim.arm.planning import Held, Planner
from lerobot_llakey.sim.mujoco_poses import body_pose, site_pose, wxyz

Colour = tuple[float, float, float]


class World:
    """The state of a scene. It does nothing by itself: :class:`~lerobot_llakey.sim.simulation.Simulation` moves it.

    Args:
        pristine: the compiled scene; it is never changed, since episodes place and paint things in a copy.
    """

    def __init__(self, pristine: mujoco.MjModel) -> None:
        self.model: mujoco.MjModel = copy.copy(pristine)
        self.data = mujoco.MjData(self.model)
        self.robot = Robot(self.model)
        self.planner = Planner(Kinematics(self.model, self.robot), self.robot)
        self.rng = np.random.default_rng(0)
        names = [name for name in dir(pristine) if name[0] != "_" and isinstance(getattr(pristine, name), np.ndarray)]
        self._arrays = {name: (getattr(self.model, name), getattr(pristine, name)) for name in names}

    def reset(self, seed: int) -> None:
        """Bring back the pristine scene, with a new random generator."""
        self.rng = np.random.default_rng(seed)
        self.vary({})
        mujoco.mj_resetData(self.model, self.data)

    def varied(self) -> dict[str, np.ndarray]:
        """Copies of the model's arrays that differ from the pristine scene's, by name."""
        return {name: array.copy() for name, (array, old) in self._arrays.items() if not np.array_equal(array, old)}

    def vary(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Make the model the pristine one, but for the given arrays (see :meth:`varied`)."""
        for name, (array, pristine) in self._arrays.items():
            array[...] = arrays.get(name, pristine)

    # What tasks ask.

    @property
    def tool(self) -> Pose:
        """Pose of the tool centre point in the base frame."""
        return self.robot.tcp_pose(self.data)

    @property
    def gripper_closed(self) -> bool:
        """Whether the gripper was last told to close."""
        return bool(self.data.ctrl[self.robot.finger_actuators[0]] < 0.5 * self.robot.open_target)

    def state(self, before: np.ndarray | None = None) -> np.ndarray:
        """(15,) float32 robot state, see schema.SIM_STATE_NAMES; its quaternion is the nearer to the state before's."""
        tool = self.tool
        quaternion = nearest_sign(tool.quaternion, DOWN if before is None else before[schema.QUATERNION])
        parts = (tool.position, quaternion, [self.robot.opening(self.data)], self.robot.joints(self.data))
        return np.concatenate(parts).astype(np.float32)

    def velocity(self) -> np.ndarray:
        """(8,) float32 velocity, see schema.SIM_VELOCITY_NAMES."""
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
