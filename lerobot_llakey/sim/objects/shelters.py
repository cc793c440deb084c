"""Low furniture that covers a cup: a cabinet on three walls and a ledge on one; both are open towards -y."""

from __future__ import annotations

import mujoco

SHELTER_HALF_WIDTH = 0.075
"""Metres from the middle of a shelter to its sides; its origin is the middle of its front edge, on the table."""
_ROOF, _DEPTH, _THICKNESS = 0.14, 0.09, 0.005
"""Height of the roof's lower face, depth, and half the boards' thickness, metres."""
_CURB, _CURB_HEIGHT, _CURB_FRONT = 0.0065, 0.015, 0.057
"""Half the width and half the height of the low curbs in a cabinet, and how far inside the one at the back begins,
metres: they keep a cup where the fingers get around it."""
_WOOD = (0.50, 0.32, 0.17, 1.0)
_STONE = (0.45, 0.47, 0.52, 1.0)


def add_cabinet(spec: mujoco.MjSpec, name: str) -> mujoco.MjsBody:
    """Add a wooden cabinet."""
    cabinet = _add_ledge(spec, name, _WOOD)
    for side in (-1, 1):
        cabinet.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=(_THICKNESS, _DEPTH / 2, _ROOF / 2),
            pos=(side * (SHELTER_HALF_WIDTH - _THICKNESS), _DEPTH / 2, _ROOF / 2),
            rgba=_WOOD,
        )
        cabinet.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=(_CURB, _DEPTH / 2, _CURB_HEIGHT),
            pos=(side * (SHELTER_HALF_WIDTH - 2 * _THICKNESS - _CURB), _DEPTH / 2, _CURB_HEIGHT),
            rgba=_WOOD,
        )
    depth = (_DEPTH - 2 * _THICKNESS - _CURB_FRONT) / 2
    cabinet.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=(SHELTER_HALF_WIDTH - 2 * _THICKNESS, depth, _CURB_HEIGHT),
        pos=(0, _CURB_FRONT + depth, _CURB_HEIGHT),
        rgba=_WOOD,
    )
    return cabinet


def add_ledge(spec: mujoco.MjSpec, name: str) -> mujoco.MjsBody:
    """Add a stone ledge: a roof on a wall."""
    return _add_ledge(spec, name, _STONE)


def _add_ledge(spec: mujoco.MjSpec, name: str, rgba: tuple[float, float, float, float]) -> mujoco.MjsBody:
    box = mujoco.mjtGeom.mjGEOM_BOX
    body = spec.worldbody.add_body(name=name)
    body.add_geom(
        type=box,
        size=(SHELTER_HALF_WIDTH, _DEPTH / 2, _THICKNESS),
        pos=(0, _DEPTH / 2, _ROOF + _THICKNESS),
        rgba=rgba,
    )
    body.add_geom(
        type=box,
        size=(SHELTER_HALF_WIDTH, _THICKNESS, _ROOF / 2),
        pos=(0, _DEPTH - _THICKNESS, _ROOF / 2),
        rgba=rgba,
    )
    return body
