"""Jars with a threaded neck, and the lid that goes on them."""

from __future__ import annotations

import mujoco
import numpy as np

from lerobot_llakey.sim.arm.panda import ARM_CONTYPE
from lerobot_llakey.sim.mujoco_poses import about_z
from lerobot_llakey.sim.objects.meshes import add_mesh, revolve
from lerobot_llakey.sim.objects.screw_thread import FIRM, THREAD_BIT

JAR_PARTS = ("body", "shoulder", "neck", "tip")
"""Geoms of a jar, after its name and an underscore."""
_JAR_RADIUS, _JAR_HEIGHT = 0.046, 0.072
_NECK_RADIUS, _NECK_TOP, _TIP_RADIUS = 0.0205, 0.096, 0.010
JAR_TOP = 0.107
"""Above the body comes a straight neck, then a cone that guides a lid set down up to a centimetre beside it."""
_LID_RADIUS, _LID_BORE, _LID_HEIGHT = 0.027, 0.022, 0.036
LID_DEPTH = 0.030
"""Height in metres of the lid's inner ceiling above its rim."""
_LID_BALL, _LID_FOOT = 0.030, 0.020
"""Radii in metres: on the ball a fallen lid rolls upright, on the foot it stands."""
_UNTOUCHED = {"contype": 0, "conaffinity": 0}
_LID_COLOUR = (0.38, 0.39, 0.42, 1.0)


def add_jar_tip(spec: mujoco.MjSpec) -> None:
    """Add the mesh of the cone on top of a jar, once."""
    add_mesh(spec, "jar_tip", *revolve([(_NECK_RADIUS, 0.0), (_TIP_RADIUS, JAR_TOP - _NECK_TOP)]))


def add_jar(spec: mujoco.MjSpec, name: str) -> mujoco.MjsBody:
    """Add a heavy jar that slides when pushed, but neither tips over nor turns; its frame stands on the table."""
    cylinder = mujoco.mjtGeom.mjGEOM_CYLINDER
    jar = spec.worldbody.add_body(name=name)
    for axis, direction in (("x", (1, 0, 0)), ("y", (0, 1, 0))):
        jar.add_joint(
            name=f"{name}_{axis}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=direction, damping=20.0, frictionloss=5.0
        )
    # A millimetre above the table: its weight and friction are in the sliding joints.
    half = (_JAR_HEIGHT - 0.001) / 2
    jar.add_geom(name=f"{name}_body", type=cylinder, size=(_JAR_RADIUS, half, 0), pos=(0, 0, 0.001 + half), mass=0.5)
    shoulder = {"type": cylinder, "size": (_JAR_RADIUS - 0.009, 0.003, 0), "pos": (0, 0, _JAR_HEIGHT + 0.002)}
    jar.add_geom(name=f"{name}_shoulder", mass=0.05, **shoulder)
    guide = {"mass": 0.05, "contype": THREAD_BIT, "conaffinity": ARM_CONTYPE, "friction": (0.2, 0.005, 0.0001), **FIRM}
    half = (_NECK_TOP - _JAR_HEIGHT) / 2
    neck_pos = (0, 0, _JAR_HEIGHT + half)
    jar.add_geom(name=f"{name}_neck", type=cylinder, size=(_NECK_RADIUS, half, 0), pos=neck_pos, **guide)
    jar.add_geom(
        name=f"{name}_tip", type=mujoco.mjtGeom.mjGEOM_MESH, meshname="jar_tip", pos=(0, 0, _NECK_TOP), **guide
    )
    return jar


def add_lid(spec: mujoco.MjSpec, yaw: float) -> None:
    """Add the free body "lid", a cap whose frame is at its rim.

    It is a cylinder to the table, an octagon to the fingers (flat faces hold firmly) and a hollow to the necks.

    Args:
        spec: the scene.
        yaw: radians about z of the face that the fingers take.
    """
    cylinder = mujoco.mjtGeom.mjGEOM_CYLINDER
    lid = spec.worldbody.add_body(name="lid")
    lid.add_freejoint(name="lid")
    half = _LID_HEIGHT / 2
    lid.add_geom(
        type=cylinder, size=(_LID_RADIUS, half, 0), pos=(0, 0, half), rgba=_LID_COLOUR, mass=0.01, **_UNTOUCHED
    )
    # Heavy below, and to the table a ball on a small foot: a lid that falls on its side rights itself.
    rests = {"contype": 0, "conaffinity": 1, "group": 4, "condim": 6, "friction": (0.8, 0.005, 0.002)}
    lid.add_geom(type=cylinder, size=(_LID_FOOT, 0.002, 0), pos=(0, 0, 0.002), mass=0.09, **rests)
    ball = mujoco.mjtGeom.mjGEOM_SPHERE
    lid.add_geom(type=ball, size=(_LID_BALL, 0, 0), pos=(0, 0, _LID_BALL), mass=0.001, **rests)
    for angle in yaw + np.arange(4) * np.pi / 4:
        face = _LID_RADIUS - 0.001
        lid.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=(face, face * np.tan(np.pi / 8), half),
            pos=(0, 0, half),
            quat=about_z(angle),
            mass=0.001,
            contype=0,
            conaffinity=ARM_CONTYPE,
            group=4,
        )
    smooth = (0.2, 0.005, 0.0001)
    inside = {"mass": 0.001, "contype": 0, "conaffinity": THREAD_BIT, "group": 4, "friction": smooth, **FIRM}
    thickness = (_LID_HEIGHT - LID_DEPTH) / 2
    lid.add_geom(type=cylinder, size=(_LID_RADIUS, thickness, 0), pos=(0, 0, LID_DEPTH + thickness), **inside)
    wall, middle = (_LID_RADIUS - _LID_BORE) / 2, (_LID_RADIUS + _LID_BORE) / 2
    for angle in np.arange(8) * np.pi / 4:
        lid.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=(wall, 0.0115, LID_DEPTH / 2),
            pos=(middle * np.cos(angle), middle * np.sin(angle), LID_DEPTH / 2),
            quat=about_z(angle),
            **inside,
        )
