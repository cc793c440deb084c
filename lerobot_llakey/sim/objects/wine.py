"""A wine bottle, and a low rack with three cradles that hold bottles lying."""

from __future__ import annotations

import mujoco
import numpy as np

from lerobot_llakey.sim.objects.meshes import add_mesh, extrude, revolve

SLOTS = ("left", "middle", "right")
PITCH = 0.082
"""Metres between two cradles of the rack."""
BOTTLE_RADIUS, NECK_RADIUS = 0.0235, 0.0105
BODY_LENGTH, SHOULDER, BOTTLE_LENGTH = 0.110, 0.132, 0.172
"""Metres from a bottle's bottom: where its body, its shoulder and its neck end."""
MIDDLE = 0.085
"""Metres from a bottle's bottom to the point that lies at the middle of a cradle."""
LYING_HEIGHT = 0.046
"""Metres from the table to the axis of a bottle in a cradle."""

_FACET = 0.023
"""Metres from the axis to the facets on which a bottle lies, and by which the fingers hold it."""
_BODY_BEAM, _NECK_BEAM, _BEAM = -0.063, 0.066, 0.012
"""Metres from the rack's middle to its two beams, and their thickness."""
_BODY_SLOPE, _NECK_SLOPE = np.deg2rad(45), np.deg2rad(55)
"""How steep the flanks of the notches are."""
_BODY_TOP, _NECK_TOP = LYING_HEIGHT + 0.006, LYING_HEIGHT + 0.018
"""Height of the beams' posts, metres."""
_RAIL = 0.008
_END = 0.005
"""Thickness of the posts' outermost part, metres."""
_HALF_WIDTH = 1.5 * PITCH + _END
_FINGER = 0.014
"""Half a fingertip's width and a little to spare, metres."""
_WOOD, _DARK_WOOD = (0.52, 0.33, 0.18, 1.0), (0.36, 0.21, 0.11, 1.0)
_LABEL = (0.95, 0.93, 0.85, 1.0)


def add_bottle_meshes(spec: mujoco.MjSpec) -> None:
    """Add the meshes that all bottles share, once a scene."""
    outline = [(0.020, 0.0), (BOTTLE_RADIUS, 0.004), (BOTTLE_RADIUS, BODY_LENGTH), (0.020, 0.119), (0.014, 0.126)]
    outline += [(NECK_RADIUS, SHOULDER), (NECK_RADIUS, 0.162), (0.0125, 0.162), (0.0125, BOTTLE_LENGTH)]
    add_mesh(spec, "wine_bottle", *revolve(outline))
    octagon = 1 / np.cos(np.pi / 8)
    hull = [(_FACET * octagon, 0.0), (_FACET * octagon, BODY_LENGTH), (NECK_RADIUS * octagon, SHOULDER)]
    add_mesh(spec, "wine_bottle_body", _facets_forward(revolve(hull, sides=8)[0]))
    neck = [(NECK_RADIUS * octagon, SHOULDER - 0.01), (NECK_RADIUS * octagon, BOTTLE_LENGTH)]
    add_mesh(spec, "wine_bottle_neck", _facets_forward(revolve(neck, sides=8)[0]))


def add_bottle(spec: mujoco.MjSpec, name: str, rgba: tuple[float, float, float, float]) -> mujoco.MjsBody:
    """Add a free bottle whose origin is the middle of its bottom, z towards its neck.

    It looks round; what touches is eight-sided, so that it lies where it was laid.
    """
    mesh = mujoco.mjtGeom.mjGEOM_MESH
    bottle = spec.worldbody.add_body(name=name, pos=(0, 0, 1))
    bottle.add_freejoint(name=name)
    looks = {"mass": 0.0, "contype": 0, "conaffinity": 0}
    bottle.add_geom(name=f"{name}_glass", type=mesh, meshname="wine_bottle", rgba=rgba, **looks)
    cylinder = mujoco.mjtGeom.mjGEOM_CYLINDER
    bottle.add_geom(type=cylinder, size=(BOTTLE_RADIUS + 0.0005, 0.022, 0), pos=(0, 0, 0.055), rgba=_LABEL, **looks)
    touch = {"type": mesh, "group": 4, "friction": (0.5, 0.01, 0.002), "condim": 6}
    bottle.add_geom(meshname="wine_bottle_body", mass=0.25, **touch)
    bottle.add_geom(meshname="wine_bottle_neck", mass=0.02, **touch)
    return bottle


def add_rack(spec: mujoco.MjSpec, name: str) -> mujoco.MjsBody:
    """Add a rack whose origin lies on the table, x towards the bottles' necks, the left cradle at positive y.

    Two notched beams: the one for the bodies is low and its notches are wide, the one for the necks higher and its
    notches narrower, so that a bottle laid in the wrong way round lies askew.
    """
    rack = spec.worldbody.add_body(name=name)
    box = mujoco.mjtGeom.mjGEOM_BOX
    for part, x, slope, radius, top in (
        ("body", _BODY_BEAM, _BODY_SLOPE, _FACET, _BODY_TOP),
        ("neck", _NECK_BEAM, _NECK_SLOPE, NECK_RADIUS, _NECK_TOP),
    ):
        # Height of the notches' deepest line.
        bottom = LYING_HEIGHT - radius / np.cos(slope)
        half = PITCH / 2
        narrow = half - (top - bottom) / np.tan(slope)
        height = top - bottom
        post = np.array(((-half, 0.0), (half, 0.0), (narrow, height), (-narrow, height)))
        end = np.array(((-half, 0.0), (_END, 0.0), (_END, height), (-narrow, height)))
        colour = _WOOD if part == "body" else _DARK_WOOD
        touch = {"type": mujoco.mjtGeom.mjGEOM_MESH, "rgba": colour, "friction": (0.3, 0.005, 0.0001)}
        for shape, polygon in (("post", post), ("end", end)):
            _add_upright(spec, f"{name}_{part}_{shape}", polygon, height)
        for y in (-PITCH / 2, PITCH / 2):
            rack.add_geom(meshname=f"{name}_{part}_post", pos=(x, y, bottom), **touch)
        for y, quaternion in ((1.5 * PITCH, (1, 0, 0, 0)), (-1.5 * PITCH, (0, 0, 0, 1))):
            rack.add_geom(meshname=f"{name}_{part}_end", pos=(x, y, bottom), quat=quaternion, **touch)
        rack.add_geom(type=box, size=(_BEAM / 2, _HALF_WIDTH, bottom / 2), pos=(x, 0, bottom / 2), rgba=colour)
    middle, length = (_BODY_BEAM + _NECK_BEAM) / 2, (_NECK_BEAM - _BODY_BEAM) / 2
    for side in (-1, 1):
        rack.add_geom(
            type=box,
            size=(length, _RAIL / 2, 0.005),
            pos=(middle, side * (_HALF_WIDTH - _RAIL / 2), 0.005),
            rgba=_DARK_WOOD,
        )
    return rack


def slot_y(slot: str) -> float:
    """Where a cradle lies along the rack's y axis, metres."""
    return PITCH * (1 - SLOTS.index(slot))


def on_beam(points: np.ndarray) -> bool:
    """Whether a fingertip at one of the points (N, 3) in the rack's frame would meet a beam."""
    x, y, z = points.T
    return any(
        bool(((np.abs(x - beam) < _FINGER + _BEAM / 2) & (np.abs(y) < _HALF_WIDTH + _FINGER) & (z < top)).any())
        for beam, top in ((_BODY_BEAM, _BODY_TOP), (_NECK_BEAM, _NECK_TOP))
    )


def _facets_forward(vertices: np.ndarray) -> np.ndarray:
    """Eight-sided vertices (M, 3) turned so that facets, not edges, face along x and y."""
    cosine, sine = np.cos(np.pi / 8), np.sin(np.pi / 8)
    return vertices @ np.array(((cosine, sine, 0), (-sine, cosine, 0), (0, 0, 1)))


def _add_upright(spec: mujoco.MjSpec, name: str, polygon: np.ndarray, height: float) -> None:
    """A board of the beams' thickness across x with an outline (N, 2) in y and z."""
    centre = np.array((0.0, height / 2))
    vertices, faces = extrude(polygon - centre, _BEAM)
    add_mesh(spec, name, vertices[:, [2, 0, 1]] + (-_BEAM / 2, *centre), faces)
