"""A made-up arm of five joints as URDF and as MJCF, without its meshes; its kinematics by hand; a recording of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from scipy.spatial.transform import Rotation

from lerobot_llakey import schema

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll")
_ORIGINS = (
    ((0.03, 0.0, 0.06), (0.1, 0.2, 0.3)),
    ((0.0, 0.02, 0.05), (1.57, 0.0, 0.4)),
    ((0.11, 0.0, 0.03), (0.0, -0.3, 0.0)),
    ((0.13, 0.01, 0.0), (0.0, 0.0, 1.2)),
    ((0.0, -0.06, 0.0), (1.5, 0.1, -0.2)),
)
"""Place in metres and roll, pitch, yaw of each joint in the link before."""
_AXES = ((0, 0, 1), (0, 1, 0), (0, 0.6, 0.8), (1, 0, 0), (0, 0, -1))
_TIP = ((0.0, 0.01, 0.09), (0.0, 1.0, 0.5))
NAMES = (*(f"{name}.pos" for name in JOINTS), "gripper.pos", "current")
"""Of a recording's numbers."""
LIMIT = 2.0
"""Radians, of all joints."""


def tip_poses(joints: np.ndarray) -> tuple[np.ndarray, Rotation]:
    """Positions (T, 3) and rotations of the tip for joints (T, 5) in radians: the product of all transforms."""
    place, turn = np.zeros((len(joints), 3)), Rotation.from_quat(np.tile((0, 0, 0, 1.0), (len(joints), 1)))
    for (offset, angles), axis, values in zip(_ORIGINS, _AXES, joints.T, strict=True):
        place = place + turn.apply(offset)
        turn = turn * Rotation.from_euler("xyz", angles) * Rotation.from_rotvec(values[:, None] * np.array(axis))
    offset, angles = _TIP
    return place + turn.apply(offset), turn * Rotation.from_euler("xyz", angles)


def write_urdf(path: Path, joints: tuple[str, ...] = JOINTS) -> Path:
    """The arm as URDF: meshes that are not there, a gripper's jaw, and the tip as a link without mass."""
    mesh = '<geometry><mesh filename="package://arm/meshes/missing.stl"/></geometry>'
    links = [f'<link name="base"><visual>{mesh}</visual></link>']
    parent = "base"
    for number, ((offset, angles), axis, name) in enumerate(zip(_ORIGINS, _AXES, joints, strict=True)):
        child = f"link_{number}"
        links.append(f'<link name="{child}"><visual>{mesh}</visual><collision>{mesh}</collision></link>')
        links.append(_joint(name, "revolute", parent, child, offset, angles, axis))
        parent = child
    links.append('<link name="jaw"/><link name="tip"/>')
    links.append(_joint("gripper", "revolute", parent, "jaw", (0.02, 0, 0), (0, 0, 0), (0, 0, 1)))
    links.append(_joint("tip_joint", "fixed", parent, "tip", *_TIP, (1, 0, 0)))
    path.write_text(f'<robot name="arm">{"".join(links)}</robot>')
    return path


def _joint(name: str, kind: str, parent: str, child: str, offset: object, angles: object, axis: object) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{_spaced(offset)}" rpy="{_spaced(angles)}"/><axis xyz="{_spaced(axis)}"/>'
        f'<limit lower="-{LIMIT}" upper="{LIMIT}" effort="1" velocity="1"/></joint>'
    )


def write_mjcf(path: Path) -> Path:
    """The arm as MJCF in degrees, with a mesh that is not there, an actuator and the tip as a site."""
    limit, inside = np.rad2deg(LIMIT), f'<site name="tip" {_placed(*_TIP)}/>'
    for number, ((offset, angles), axis, name) in reversed(list(enumerate(zip(_ORIGINS, _AXES, JOINTS, strict=True)))):
        joint = f'<joint name="{name}" axis="{_spaced(axis)}" range="-{limit} {limit}"/>'
        geom = '<geom type="mesh" mesh="missing"/>'
        inside = f'<body name="link_{number}" {_placed(offset, angles)}>{joint}{geom}{inside}</body>'
    path.write_text(
        f'<mujoco><compiler angle="degree"/><asset><mesh name="missing" file="missing.stl"/></asset><worldbody>'
        f'<body name="base">{inside}</body></worldbody><actuator><position joint="{JOINTS[0]}"/></actuator></mujoco>'
    )
    return path


def _placed(offset: object, angles: object) -> str:
    quaternion = Rotation.from_euler("xyz", np.asarray(angles)).as_quat()[[3, 0, 1, 2]]
    return f'pos="{_spaced(offset)}" quat="{_spaced(quaternion)}"'


def _spaced(numbers: object) -> str:
    return " ".join(map(str, np.asarray(numbers).tolist()))


def moved() -> np.ndarray:
    """Joints (46, 5) in radians and an opening 0..100: down, the gripper closes, up; a rest after each, at 10 fps."""
    down, close, up = (
        np.clip((np.arange(46) - begin) / length, 0, 1) for begin, length in ((0, 10), (15, 3), (25, 12))
    )
    joints = (
        np.array([0.3, -0.4, 0.8, 0.5, 0.2])
        + down[:, None] * (0.5, 0.6, -0.4, 0.3, 0)
        - up[:, None] * (0, 0.7, 0, 0, 1)
    )
    return np.column_stack((joints, 100 - 60 * close))


def recording(root: Path, names: tuple[str, ...] = NAMES, scale: float = 180 / np.pi) -> LeRobotDataset:
    """One episode, as LeRobot records an SO-101 in degrees: state and action are joints."""
    features: dict[str, Any] = {key: schema.vector(names) for key in (schema.STATE, schema.ACTION)}
    dataset = LeRobotDataset.create("me/joints", 10, features, root=root, use_videos=False)
    for row in moved():
        numbers = np.array([*(row[:5] * scale), row[5], 7.0], dtype=np.float32)
        dataset.add_frame({schema.STATE: numbers, schema.ACTION: numbers, schema.TASK: "take the cup"})
    dataset.save_episode()
    dataset.finalize()
    return LeRobotDataset("me/joints", root=root)
