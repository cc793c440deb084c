"""A Franka Panda with a parallel gripper: its MuJoCo model and the indices to read and drive it."""

from __future__ import annotations

from importlib import resources
from pathlib import PurePosixPath

import mujoco
import numpy as np

from lerobot_llakey.errors import MissingFileError
from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.mujoco_poses import site_pose

ARM_JOINTS: tuple[str, ...] = tuple(f"joint{i}" for i in range(1, 8))
FINGER_JOINTS: tuple[str, str] = ("left_finger", "right_finger")
HOME_JOINTS = np.array([0.0, -0.7621, 0.0, -2.4378, 0.0, 1.6757, np.pi / 4])
"""Joint angles (radians) at the start of an episode: the hand above the table, pointing down."""
FINGER_TRAVEL = 0.04
"""Metres that each finger slides from closed to open."""
TCP_OFFSET = 0.1034
"""Metres from the hand's flange to the point between the fingertips (Franka hand's data sheet)."""

VISUAL_GROUP, HULL_GROUP = 2, 3
"""Geom groups of the detailed meshes (the human's camera) and of the collision hulls (the policy's cameras)."""
ARM_CONTYPE, ARM_CONAFFINITY = 2, 1
"""The arm touches the scene (contype 1) but not itself."""

_SERVO = ((3000, 150, 87),) * 2 + ((2500, 120, 87),) * 2 + ((800, 40, 12),) * 3
_GRIP_FORCE = 40.0
_HAND_COLOUR = (0.92, 0.92, 0.92, 1.0)
_FINGER_COLOUR = (0.25, 0.25, 0.27, 1.0)


def panda_spec(detailed: bool = False) -> mujoco.MjSpec:
    """The arm of the ``gym-hil`` wheel with its gripper replaced by the Franka hand built from primitives.

    Args:
        detailed: keep the visual meshes (192,394 faces) for the human's camera beside the hulls (2,126 faces).

    Sites: ``tcp`` lies between the fingertips, z out of the hand, the fingers open along y.

    Raises:
        MissingFileError: if the gym-hil wheel carries no Panda model.
    """
    path = resources.files("gym_hil") / "assets" / "panda.xml"
    if not path.is_file():
        raise MissingFileError(f"Expected the Panda model of gym-hil at {path}, found none; reinstall gym-hil.")
    spec = mujoco.MjSpec.from_file(str(path))
    for collection in (spec.equalities, spec.tendons, spec.excludes, spec.actuators, spec.keys, spec.sensors):
        for element in list(collection):
            spec.delete(element)
    spec.delete(spec.body("attachment"))
    for body in spec.bodies:
        body.gravcomp = 1.0
        for geom in list(body.geoms):
            if not detailed and geom.group == VISUAL_GROUP:
                spec.delete(geom)
                continue
            if geom.classname is not None and geom.classname.name == "panda/collision":
                geom.group, geom.rgba = HULL_GROUP, _HAND_COLOUR
                geom.contype, geom.conaffinity = ARM_CONTYPE, ARM_CONAFFINITY
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if (mesh.name or PurePosixPath(mesh.file).stem) not in used:
            spec.delete(mesh)
    for name, (stiffness, damping, force) in zip(ARM_JOINTS, _SERVO, strict=True):
        _add_servo(spec, name, stiffness, damping, force)
    _add_hand(spec)
    return spec


def _add_servo(spec: mujoco.MjSpec, joint: str, stiffness: float, damping: float, force: float) -> None:
    actuator = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.gaintype, actuator.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    actuator.gainprm[0] = stiffness
    actuator.biasprm[:3] = (0.0, -stiffness, -damping)
    actuator.forcelimited, actuator.forcerange = True, (-force, force)


def _add_hand(spec: mujoco.MjSpec) -> None:
    box = mujoco.mjtGeom.mjGEOM_BOX
    touch = {"contype": ARM_CONTYPE, "conaffinity": ARM_CONAFFINITY}
    # The hand is mounted turned by -45 degrees about the flange's z axis.
    hand = spec.body("link7").add_body(
        name="hand", pos=(0, 0, 0.107), quat=(np.cos(np.pi / 8), 0, 0, -np.sin(np.pi / 8)), gravcomp=1.0
    )
    hand.add_geom(type=box, size=(0.02, 0.1, 0.033), pos=(0, 0, 0.033), mass=0.7, rgba=_HAND_COLOUR, **touch)
    hand.add_site(name="tcp", pos=(0, 0, TCP_OFFSET), group=5)
    for name, side in zip(FINGER_JOINTS, (1.0, -1.0), strict=True):
        finger = hand.add_body(name=name, pos=(0, 0, 0.0584), gravcomp=1.0)
        finger.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_SLIDE,
            axis=(0, side, 0),
            range=(0, FINGER_TRAVEL),
            limited=True,
            armature=0.1,
            damping=10.0,
        )
        finger.add_geom(
            type=box, size=(0.0105, 0.006, 0.014), pos=(0, side * 0.012, 0.012), mass=0.02, rgba=_FINGER_COLOUR, **touch
        )
        finger.add_geom(
            name=f"{name}_pad",
            type=box,
            size=(0.0105, 0.004, 0.0165),
            pos=(0, side * 0.004, 0.0375),
            mass=0.02,
            rgba=_FINGER_COLOUR,
            friction=(1.6, 0.03, 0.0005),
            condim=4,
            priority=1,
            solimp=(0.9, 0.95, 0.003, 0.5, 2),
            # Stiffness and damping: what a moving hand holds creeps through MuJoCo's friction by one over the damping.
            solref=(-10000, -400),
            **touch,
        )
        _add_servo(spec, name, 1000.0, 40.0, _GRIP_FORCE)
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=FINGER_JOINTS[0],
        name2=FINGER_JOINTS[1],
        data=(0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0),
        solref=(0.03, 1),
    )


class Robot:
    """Indices of the Panda inside a compiled model, and its state and targets inside a data."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model = model
        joints = [model.joint(name) for name in ARM_JOINTS]
        fingers = [model.joint(name) for name in FINGER_JOINTS]
        self.qpos = np.array([joint.qposadr[0] for joint in joints])
        self.dofs = np.array([joint.dofadr[0] for joint in joints])
        self.finger_qpos = np.array([joint.qposadr[0] for joint in fingers])
        self.finger_dofs = np.array([joint.dofadr[0] for joint in fingers])
        self.limits = np.array([joint.range for joint in joints])
        self.actuators = np.array([model.actuator(name).id for name in ARM_JOINTS])
        self.finger_actuators = np.array([model.actuator(name).id for name in FINGER_JOINTS])
        self.tcp = model.site("tcp").id
        self.pads = tuple(model.geom(f"{name}_pad").id for name in FINGER_JOINTS)
        self.velocity_gain = np.array([damping / stiffness for stiffness, damping, _ in _SERVO])
        """Seconds by which a servo lags a moving target: stiffness and damping of each joint's ratio."""
        root = model.body("link0").id
        self.open_target = FINGER_TRAVEL
        self.geoms = np.flatnonzero(model.body_rootid[model.geom_bodyid] == root)

    @property
    def longest_reach(self) -> float:
        """Metres from the base beyond which the tool centre point cannot be: the length of all links in a row."""
        length, body = float(np.linalg.norm(self.model.site_pos[self.tcp])), int(self.model.site_bodyid[self.tcp])
        while body:
            length += float(np.linalg.norm(self.model.body_pos[body]))
            body = int(self.model.body_parentid[body])
        return length

    def tcp_pose(self, data: mujoco.MjData) -> Pose:
        return site_pose(data, self.tcp)

    def joints(self, data: mujoco.MjData) -> np.ndarray:
        """(7,) joint angles in radians."""
        return data.qpos[self.qpos].copy()

    def opening(self, data: mujoco.MjData) -> float:
        """Gripper opening from 0 (closed) to 1 (open)."""
        return float(np.clip(data.qpos[self.finger_qpos].mean() / FINGER_TRAVEL, 0.0, 1.0))

    def velocity(self, data: mujoco.MjData) -> np.ndarray:
        """(8,) joint velocities in radians a second, and by how much of its opening the gripper opens a second."""
        return np.append(data.qvel[self.dofs], data.qvel[self.finger_dofs].mean() / FINGER_TRAVEL)

    def set_joints(self, data: mujoco.MjData, joints: np.ndarray, opening: float = 1.0) -> None:
        """Place the arm at rest at joint angles (7,) with the given gripper opening, targets included."""
        data.qpos[self.qpos], data.qvel[self.dofs] = joints, 0.0
        data.ctrl[self.actuators] = joints
        data.qpos[self.finger_qpos], data.qvel[self.finger_dofs] = opening * FINGER_TRAVEL, 0.0
        data.ctrl[self.finger_actuators] = opening * FINGER_TRAVEL
