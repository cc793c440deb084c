"""A light bulb that always stands up again, and the socket that it is screwed into."""

from __future__ import annotations

import mujoco
import numpy as np

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.arm.panda import ARM_CONTYPE
from lerobot_llakey.sim.mujoco_poses import about_z
from lerobot_llakey.sim.objects.meshes import add_mesh, revolve
from lerobot_llakey.sim.objects.screw_thread import FIRM, THREAD_BIT

Rgba = tuple[float, float, float, float]

GLASS_RADIUS, GLASS_HEIGHT = 0.027, 0.058
"""Metres: radius of the glass where fingers take it, and height of its middle above the tip."""
BULB_TOP = 0.085
SCREW_RADIUS, SCREW_TOP = 0.013, 0.030
"""The screw base: its radius, and the height at which it ends, above the tip. Metres."""
_TIP_RADIUS, _TIP_HEIGHT = 0.006, 0.008
"""The screw ends in a cone, which slips into a socket that it misses by more than a centimetre."""
TRAVEL, ANGLE = 0.008, np.deg2rad(105)
"""Metres that a bulb sinks by in its socket, and radians of the whole thread."""
SOCKET_DEPTH, SOCKET_RADIUS = 0.027, 0.024
"""Metres from the tip of a bulb that is screwed in to the socket's rim, and the socket's outer radius."""
_BORE, _CHAMFER = 0.0145, 0.006
_COLLAR_TOP = -10.0
"""Degrees of latitude up to which the collar covers the glass."""
_FACET = 0.012
"""Half the height of the glass's flat sides."""
_BULB_BIT = 8
_CENTRE_OF_MASS, _MASS = 0.0035, 0.1
"""Metres above the tip, and kilograms: so low that a bulb on its side rolls over the screw's edge back onto its tip."""
_METAL: Rgba = (0.62, 0.63, 0.66, 1.0)
_BRASS: Rgba = (0.45, 0.36, 0.16, 1.0)
_SIDES = 8


def add_bulb_meshes(spec: mujoco.MjSpec) -> None:
    """Add what all bulbs and sockets of a scene share; once, before them."""
    add_mesh(spec, "bulb_glass", *revolve(glass_profile()))
    bowl = np.deg2rad(np.linspace(-50, _COLLAR_TOP, 5))
    radius = GLASS_RADIUS + 0.0005
    cup = np.column_stack((radius * np.cos(bowl), GLASS_HEIGHT + radius * np.sin(bowl)))
    add_mesh(spec, "bulb_collar", *revolve([(0.0125, SCREW_TOP - 0.001), (0.0150, SCREW_TOP + 0.002), *cup]))
    tip, ridges = [(_TIP_RADIUS, 0.0), (SCREW_RADIUS, _TIP_HEIGHT)], np.linspace(_TIP_HEIGHT, SCREW_TOP, 9)
    groove = [(SCREW_RADIUS - 0.002 * (index % 2), z) for index, z in enumerate(ridges)]
    add_mesh(spec, "bulb_screw", *revolve([*tip, *groove[1:]], 16))
    add_mesh(spec, "bulb_tip", *revolve(tip, 16))
    outer = SOCKET_RADIUS
    profile = ((_BORE, 0), (_BORE, SOCKET_DEPTH - _CHAMFER), (_BORE + _CHAMFER, SOCKET_DEPTH), (outer, SOCKET_DEPTH))
    half = np.tan(np.pi / _SIDES)
    corners = [(r, side * r * half, z) for r, z in (*profile, (outer, 0)) for side in (-1, 1)]
    add_mesh(spec, "socket_wall", np.array(corners))


def glass_profile(thicker: float = 0.0) -> np.ndarray:
    """(N, 2) outline of the glass above its collar, some metres thicker than it is."""
    angles, radius = np.deg2rad(np.linspace(_COLLAR_TOP, 90, 9)), GLASS_RADIUS + 0.0005 + thicker
    return np.column_stack((radius * np.cos(angles), GLASS_HEIGHT + radius * np.sin(angles)))


def add_bulb(spec: mujoco.MjSpec, name: str, glass: Rgba, collar: Rgba) -> mujoco.MjsBody:
    """Add a free bulb; its frame lies at the tip, z upwards, a pair of flat sides across y.

    Its drawn parts are the geoms ``{name}_glass``, ``{name}_collar`` and ``{name}_screw``. To the table it is a ball on
    a screw, to fingers an octagon (flat faces hold firmly), to sockets the screw alone.
    """
    mesh, box = mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_BOX
    bulb = spec.worldbody.add_body(name=name)
    bulb.explicitinertial, bulb.mass, bulb.ipos = True, _MASS, (0, 0, _CENTRE_OF_MASS)
    bulb.inertia = (4e-5, 4e-5, 2e-5)
    bulb.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_FREE, damping=3e-4)
    drawn = {"type": mesh, "contype": 0, "conaffinity": 0}
    for part, colour in (("glass", glass), ("collar", collar), ("screw", _METAL)):
        bulb.add_geom(name=f"{name}_{part}", meshname=f"bulb_{part}", rgba=colour, **drawn)
    solid = {"contype": _BULB_BIT, "conaffinity": 1 | THREAD_BIT | _BULB_BIT, "group": 4, "condim": 6}
    rolling = (0.6, 0.005, 0.0005)
    ball = {"type": mujoco.mjtGeom.mjGEOM_SPHERE, "size": (GLASS_RADIUS, 0, 0)}
    bulb.add_geom(pos=(0, 0, GLASS_HEIGHT), friction=rolling, **ball, **solid)
    smooth = (0.2, 0.005, 0.0001)
    half = (SCREW_TOP - _TIP_HEIGHT) / 2
    shank = {"type": mujoco.mjtGeom.mjGEOM_CYLINDER, "size": (SCREW_RADIUS, half, 0), "pos": (0, 0, _TIP_HEIGHT + half)}
    bulb.add_geom(friction=smooth, **shank, **solid, **FIRM)
    bulb.add_geom(type=mesh, meshname="bulb_tip", friction=smooth, **solid, **FIRM)
    face = GLASS_RADIUS - 0.001
    for angle in np.arange(4) * np.pi / 4:
        bulb.add_geom(
            type=box,
            size=(face, face * np.tan(np.pi / 8), _FACET),
            pos=(0, 0, GLASS_HEIGHT),
            quat=about_z(angle),
            contype=0,
            conaffinity=ARM_CONTYPE,
            group=4,
        )
    return bulb


def add_socket(host: mujoco.MjsBody, height: float) -> None:
    """Add a ring with a chamfered bore to a fixed body.

    Args:
        host: upright, the socket's axis being its z axis.
        height: of a bulb's tip that is screwed in, in the host's frame (metres).
    """
    for index in range(_SIDES):
        host.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname="socket_wall",
            pos=(0, 0, height),
            quat=about_z(index * 2 * np.pi / _SIDES),
            rgba=_BRASS,
            contype=THREAD_BIT,
            conaffinity=ARM_CONTYPE,
            friction=(0.2, 0.005, 0.0001),
            **FIRM,
        )


def glass_middle(bulb: Pose) -> np.ndarray:
    """(3,) middle of the glass of a bulb that stands or leans: where a hand takes it."""
    return bulb.apply(np.array((0.0, 0.0, GLASS_HEIGHT)))


def facing(yaw: float) -> np.ndarray:
    """Quaternion (xyzw) of an upright bulb with flat sides to the fingers of a hand at a yaw (radians)."""
    return np.array((0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)))
