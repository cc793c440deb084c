"""A tumbler: round to the eye; to the physics twelve flat staves and a bottom."""

from __future__ import annotations

import mujoco
import numpy as np

from lerobot_llakey.sim.mujoco_poses import about_z
from lerobot_llakey.sim.objects.meshes import add_mesh, revolve

CUP_RADIUS, CUP_HEIGHT, CUP_WALL = 0.031, 0.12, 0.005
"""Outside measures and the wall's thickness, metres."""
_BOTTOM, _STAVES, _FEET = 0.006, 12, 4
_INSIDE = (0.20, 0.17, 0.17, 1.0)
"""The inside is dark, so that an opening shows in a small picture."""
_FRICTION = (0.8, 0.01, 0.001)
"""A cup on its side soon stops rolling; more friction would let a tilted one stand on its edge."""


def add_cup(spec: mujoco.MjSpec, name: str, colour: tuple[float, float, float]) -> mujoco.MjsBody:
    """Add a free cup; its origin is the middle of its bottom, z points to its opening.

    It stands on four feet, at the bottom as at the rim: a few contacts are faster and steadier than rings of them.
    """
    cup = spec.worldbody.add_body(name=name, pos=(0, 0, 1))
    cup.add_freejoint()
    _add_looks(spec, cup, name, colour)
    hidden = {"group": 4, "friction": _FRICTION}
    stave = add_mesh(spec, f"{name}_stave", _stave())
    for angle in np.arange(_STAVES) * 2 * np.pi / _STAVES:
        cup.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH, meshname=stave, quat=about_z(angle), mass=0.022, condim=6, **hidden
        )
    middle, foot = CUP_RADIUS - CUP_WALL / 2, CUP_WALL / 2
    for angle in (np.arange(_FEET) + 0.5) * 2 * np.pi / _FEET:
        for height in (foot, CUP_HEIGHT - foot):
            cup.add_geom(
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=(foot, 0, 0),
                pos=(middle * np.cos(angle), middle * np.sin(angle), height),
                mass=0.001,
                **hidden,
            )
    half = (_BOTTOM - 0.001) / 2
    cup.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=(CUP_RADIUS - 0.001, half, 0),
        pos=(0, 0, 0.001 + half),
        mass=0.06,
        **hidden,
    )
    return cup


def _stave() -> np.ndarray:
    """(8, 3) corners of one piece of the wall: what a plane at the inner radius cuts off a solid twelve-sided cup.

    Each piece tapers into its neighbours. Were they boxes, a fingertip that sinks a little into a seam would be held
    there between the ends of two of them.
    """
    outer, inner, step = CUP_RADIUS, CUP_RADIUS - CUP_WALL, 2 * np.pi / _STAVES
    near = outer * np.tan(step / 2)
    far = (outer - inner * np.cos(step)) / np.sin(step)
    outline = np.array(((outer, near), (inner, far), (inner, -far), (outer, -near)))
    return np.concatenate([np.column_stack((outline, np.full(4, z))) for z in (0.001, CUP_HEIGHT - 0.001)])


def _add_looks(spec: mujoco.MjSpec, cup: mujoco.MjsBody, name: str, colour: tuple[float, float, float]) -> None:
    inner = CUP_RADIUS - CUP_WALL
    outline = ((0, 0), (CUP_RADIUS, 0), (CUP_RADIUS, CUP_HEIGHT), (inner, CUP_HEIGHT), (inner, _BOTTOM), (0, _BOTTOM))
    skin, floor, brim = inner - 0.0008, _BOTTOM + 0.0008, CUP_HEIGHT - 0.004
    lining = ((0, _BOTTOM), (inner, _BOTTOM), (inner, brim), (skin, brim), (skin, floor), (0, floor))
    for part, profile, rgba in (("outside", outline, (*colour, 1.0)), ("inside", lining, _INSIDE)):
        cup.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=add_mesh(spec, f"{name}_{part}", *revolve(profile, 24)),
            mass=0.0,
            contype=0,
            conaffinity=0,
            rgba=rgba,
        )
