"""A lamp with a socket that lights up, and coloured holders in which bulbs stand."""

from __future__ import annotations

import mujoco

from lerobot_llakey.sim.arm.panda import ARM_CONTYPE
from lerobot_llakey.sim.objects.bulb import SOCKET_DEPTH, SOCKET_RADIUS, add_socket, glass_profile
from lerobot_llakey.sim.objects.meshes import add_mesh, revolve
from lerobot_llakey.sim.world import World

SEAT = 0.035
"""Height above the table of the tip of a bulb that is screwed into the lamp."""
HOLDER_HEIGHT = 0.020
_HOLDER, _HOLE = 0.042, 0.0175
"""Half the holder's width, and half the width of its hole, metres."""
_FOOT_RADIUS, _FOOT_HEIGHT = 0.055, 0.012
_BLACK = (0.16, 0.17, 0.20, 1.0)
_LIGHT = (1.0, 0.88, 0.25, 1.0)
_THICKER = 0.0015
"""Metres by which the light covers the glass; a bulb is not quite at the thread's end where it lights up."""
_DARK = -0.4
"""Metres: where the light waits below the table while the lamp is off."""


def add_lamp(spec: mujoco.MjSpec, name: str) -> mujoco.MjsBody:
    """Add a fixed lamp: a foot, a stem, a socket, and a light that shows once it is switched on.

    The light is a glowing shell where a bulb's glass is. It is off while it is out of sight: so the light
    is part of the scene's state, and a picture rendered from a recorded state has it too. It touches nothing.
    """
    foot = [(_FOOT_RADIUS, 0.0), (_FOOT_RADIUS, 0.006), (SOCKET_RADIUS, _FOOT_HEIGHT), (SOCKET_RADIUS - 0.004, SEAT)]
    add_mesh(spec, f"{name}_stand", *revolve(foot))
    lamp = spec.worldbody.add_body(name=name)
    cylinder = mujoco.mjtGeom.mjGEOM_CYLINDER
    unseen = {"type": cylinder, "group": 4}
    lamp.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"{name}_stand", rgba=_BLACK, contype=0, conaffinity=0)
    half = _FOOT_HEIGHT / 2
    lamp.add_geom(size=(_FOOT_RADIUS, half, 0), pos=(0, 0, half), **unseen)
    # Inside the socket only the thread's nut carries a bulb.
    lamp.add_geom(
        size=(SOCKET_RADIUS, (SEAT + SOCKET_DEPTH) / 2, 0),
        pos=(0, 0, (SEAT + SOCKET_DEPTH) / 2),
        contype=0,
        conaffinity=ARM_CONTYPE,
        **unseen,
    )
    add_socket(lamp, SEAT)
    add_mesh(spec, f"{name}_light", *revolve(glass_profile(_THICKER)))
    spec.add_material(name=f"{name}_light", emission=1.0, rgba=_LIGHT)
    light = lamp.add_body(name=f"{name}_light", gravcomp=1.0)
    light.add_joint(name=f"{name}_light", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=(0, 0, 1), damping=1.0, armature=1.0)
    light.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=f"{name}_light",
        pos=(0, 0, SEAT + _DARK),
        mass=0.01,
        material=f"{name}_light",
        contype=0,
        conaffinity=0,
    )
    return lamp


def switch(world: World, name: str, on: bool) -> None:
    """Switch a lamp's light; it costs nothing where the light is so already."""
    if (world.joint(f"{name}_light") > -_DARK / 2) != on:
        world.set_joint(f"{name}_light", -_DARK if on else 0.0)


def add_holder(spec: mujoco.MjSpec, name: str) -> None:
    """Add a low square block with a hole through which a bulb stands on the table."""
    holder = spec.worldbody.add_body(name=name)
    wall, middle, half = (_HOLDER - _HOLE) / 2, (_HOLDER + _HOLE) / 2, HOLDER_HEIGHT / 2
    for index, (x, y) in enumerate(((1, 0), (-1, 0), (0, 1), (0, -1))):
        holder.add_geom(
            name=f"{name}_{index}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=(wall, _HOLDER, half) if x else (_HOLE, wall, half),
            pos=(x * middle, y * middle, half),
            friction=(0.3, 0.005, 0.0001),
        )


def paint_holder(world: World, name: str, colour: tuple[float, float, float]) -> None:
    """Colour a holder with RGB in 0..1."""
    for index in range(4):
        world.paint(f"{name}_{index}", colour)
