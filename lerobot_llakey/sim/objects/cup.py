"""A tumbler: round to the eye, twelve walls and a bottom to the physics."""

from __future__ import annotations

import mujoco
import numpy as np

from lerobot_llakey.sim.meshes import add_mesh, revolve

CUP_RADIUS, CUP_HEIGHT, CUP_WALL = 0.032, 0.115, 0.0045
"""Outside measures and the wall's thickness, metres."""
_BOTTOM, _WALLS, _FEET, _FOOT = 0.006, 12, 4, 0.00225
_INSIDE = (0.20, 0.17, 0.17, 1.0)
"""The inside is dark, so that an opening shows in a small picture."""
_STILL = {"condim": 6, "friction": (0.8, 0.01, 0.005)}
"""A cup on its side does not roll away."""


def add_cup(spec: mujoco.MjSpec, name: str, colour: tuple[float, float, float]) -> mujoco.MjsBody:
    """Add a free cup; its origin is the middle of its bottom, z points to its opening.

    It stands on four feet, at the bottom as at the rim: a few contacts are faster and steadier than rings of them.
    """
    cup = spec.worldbody.add_body(name=name, pos=(0, 0, 1))
    cup.add_freejoint()
    _add_looks(spec, cup, name, colour)
    hidden = {"group": 4, **_STILL}
    middle = CUP_RADIUS - CUP_WALL / 2
    for angle in np.arange(_WALLS) * 2 * np.pi / _WALLS:
        cup.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=(CUP_WALL / 2, CUP_RADIUS * np.tan(np.pi / _WALLS), CUP_HEIGHT / 2 - 0.001),
            pos=(middle * np.cos(angle), middle * np.sin(angle), CUP_HEIGHT / 2),
            quat=(np.cos(angle / 2), 0, 0, np.sin(angle / 2)),
            mass=0.007,
            **hidden,
        )
    half = (_BOTTOM - 0.001) / 2
    cup.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=(CUP_RADIUS - 0.001, half, 0),
        pos=(0, 0, 0.001 + half),
        mass=0.02,
        **hidden,
    )
    for angle in np.arange(_FEET) * 2 * np.pi / _FEET + np.pi / _WALLS:
        for height in (_FOOT, CUP_HEIGHT - _FOOT):
            cup.add_geom(
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=(_FOOT, 0, 0),
                pos=(middle * np.cos(angle), middle * np.sin(angle), height),
                mass=0.001,
                group=4,
                friction=(0.8, 0.01, 0.0001),
            )
    return cup


def _add_looks(spec: mujoco.MjSpec, cup: mujoco.MjsBody, name: str, colour: tuple[float, float, float]) -> None:
    inner = CUP_RADIUS - CUP_WALL
    outline = ((0, 0), (CUP_RADIUS, 0), (CUP_RADIUS, CUP_HEIGHT), (inner, CUP_HEIGHT), (inner, _BOTTOM), (0, _BOTTOM))
    skin, brim = inner - 0.0008, CUP_HEIGHT - 0.004
    lining = ((0, _BOTTOM), (inner, _BOTTOM), (inner, brim), (skin, brim), (skin, _BOTTOM + 0.0008), (0, _BOTTOM + 0.0008))
    for part, profile, rgba in (("cup", outline, (*colour, 1.0)), ("lining", lining, _INSIDE)):
        cup.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=add_mesh(spec, f"{name}_{part}", *revolve(profile, 24)),
            mass=0.0,
            contype=0,
            conaffinity=0,
            rgba=rgba,
        )
