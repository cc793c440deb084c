"""The five shapes of a toddler's sorter: low blocks with a heavy foot and a bar on top to hold them by."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from lerobot_llakey.sim.arm.panda import ARM_CONTYPE
from lerobot_llakey.sim.objects.meshes import add_mesh

BODY_HEIGHT = 0.025
BAR_HALF = (0.015, 0.007, 0.014)
"""Half the bar's length (along the shape's x axis), width (between the fingers) and height, metres."""
GRIP = BODY_HEIGHT + 0.016
"""Height of the fingertips above a standing shape's base when they hold its bar."""
HEIGHT = BODY_HEIGHT + 2 * BAR_HALF[2]
_TAPER, _TAPER_HEIGHT = 0.0032, 0.012
"""Metres by which the base is narrower on every side, and height up to which: a shape finds its hole, and does not rest
on a side."""
_MASS, _BALANCE = 0.15, 0.002
"""Kilogrammes, and metres from the base to the centre of mass: the foot is of lead."""
_INERTIA = (2.3e-5, 2.3e-5, 4.6e-5)
SHAPE_BIT, _TABLE_BIT = 8, 1
"""Contact bits of shapes and their sorter among themselves, and of the table."""
TOUCH: dict[str, Any] = {
    "contype": SHAPE_BIT,
    "conaffinity": SHAPE_BIT | ARM_CONTYPE,
    "friction": (0.2, 0.005, 0.0001),
}
"""How shapes and their sorter touch each other and the arm: they are smooth."""
_FOOT_FRICTION = (0.3, 0.005, 0.0001)
"""Pushed by its bar a shape slides on the table rather than tip over."""
_FOOT = 0.002
"""Radius in metres of the beads on which a shape meets the table: MuJoCo finds these contacts far more surely than
those of a mesh."""


@dataclass(frozen=True, eq=False)
class Shape:
    """One kind of block.

    Attributes:
        name: as the words say it.
        colour: RGB in 0..1.
        fold: how many turns about z leave its outline as it is; 0 where any turn does.
        outline: (N, 2) corners of its top in metres, counter-clockwise.
        pieces: indices of the corners of convex parts; -1 is the origin.
        feet: indices of the corners by which it meets the table.
        eye: a point that sees every edge of the outline from inside.
    """

    name: str
    colour: tuple[float, float, float]
    fold: int
    outline: np.ndarray
    pieces: tuple[tuple[int, ...], ...]
    feet: tuple[int, ...]
    eye: tuple[float, float] = (0.0, 0.0)

    @property
    def body(self) -> str:
        """Name of its body in the scene."""
        return self.name.replace(" ", "_")


def widened(outline: ArrayLike, distance: float) -> np.ndarray:
    """The outline (N, 2), counter-clockwise, with every edge moved outwards by ``distance`` metres."""
    corners = np.asarray(outline, dtype=np.float64)
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack((edges[:, 1], -edges[:, 0])) / np.linalg.norm(edges, axis=1, keepdims=True)
    before = np.roll(normals, 1, axis=0)
    return corners + distance * (normals + before) / (1 + (normals * before).sum(axis=1, keepdims=True))


def add_shape(spec: mujoco.MjSpec, shape: Shape) -> None:
    """Add a shape as a free body whose origin is the middle of its base."""
    body = spec.worldbody.add_body(name=shape.body, pos=(0, 0, 1))
    body.add_freejoint(name=shape.body)
    body.mass, body.ipos, body.inertia, body.explicitinertial = _MASS, (0, 0, _BALANCE), _INERTIA, True
    for index, piece in enumerate(shape.pieces):
        mesh = add_mesh(spec, f"{shape.body}_{index}", _corners(shape, piece))
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh, rgba=(*shape.colour, 1.0), **TOUCH)
    for x, y, z in _corners(shape, shape.feet):
        inwards = 1 - _FOOT / np.hypot(x, y)
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=(_FOOT, 0, 0),
            pos=(inwards * x, inwards * y, z - _FOOT if z else _FOOT),
            contype=0,
            conaffinity=_TABLE_BIT,
            priority=1,
            friction=_FOOT_FRICTION,
            group=4,
        )
    touch = {**TOUCH, "conaffinity": TOUCH["conaffinity"] | _TABLE_BIT}
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=BAR_HALF,
        pos=(0, 0, BODY_HEIGHT + BAR_HALF[2]),
        rgba=(*(0.6 * np.array(shape.colour)), 1.0),
        **touch,
    )


def extent(shape: Shape, rotation: Rotation) -> float:
    """Height in metres of a turned shape's lowest point above its origin."""
    corners = _corners(shape, range(len(shape.outline)))
    bar = [(x, y, HEIGHT) for x in (-BAR_HALF[0], BAR_HALF[0]) for y in (-BAR_HALF[1], BAR_HALF[1])]
    return float(rotation.apply(np.concatenate((corners, bar)))[:, 2].min())


def _corners(shape: Shape, piece: Iterable[int]) -> np.ndarray:
    """(3 N, 3) corners of a convex part: at the base, where the taper ends and at the top."""
    chosen = list(piece)
    levels = ((widened(shape.outline, -_TAPER), 0.0), (shape.outline, _TAPER_HEIGHT), (shape.outline, BODY_HEIGHT))
    rings = [(np.concatenate((ring, [(0.0, 0.0)]))[chosen], z) for ring, z in levels]
    return np.concatenate([np.column_stack((ring, np.full(len(ring), z))) for ring, z in rings])


def _blunt(corners: np.ndarray, width: float) -> np.ndarray:
    """Every corner (N, 2) replaced by two, ``width`` metres along its edges."""
    before, after = np.roll(corners, 1, axis=0) - corners, np.roll(corners, -1, axis=0) - corners
    steps = [width * edge / np.linalg.norm(edge, axis=1, keepdims=True) for edge in (before, after)]
    return np.stack([corners + step for step in steps], axis=1).reshape(-1, 2)


def _polar(radii: ArrayLike, degrees: ArrayLike) -> np.ndarray:
    angles = np.deg2rad(np.asarray(degrees, dtype=np.float64))
    return np.asarray(radii, dtype=np.float64).reshape(-1, 1) * np.column_stack((np.cos(angles), np.sin(angles)))


def _all(outline: np.ndarray) -> tuple[tuple[int, ...], ...]:
    return (tuple(range(len(outline))),)


def _cube() -> Shape:
    outline = 0.020 * np.array(((1, -1), (1, 1), (-1, 1), (-1, -1)))
    return Shape("cube", (0.85, 0.10, 0.10), 4, outline, _all(outline), (0, 1, 2, 3))


def _cylinder() -> Shape:
    outline = _polar([0.0242], np.arange(16) * 22.5)
    return Shape("cylinder", (0.10, 0.25, 0.90), 0, outline, _all(outline), (0, 3, 5, 8, 11, 13))


def _triangular_prism() -> Shape:
    outline = _blunt(_polar([0.0325], (0, 120, 240)), 0.006)
    return Shape("triangular prism", (0.10, 0.60, 0.20), 3, outline, _all(outline), tuple(range(6)))


def _star() -> Shape:
    """Five blunt rays: two corners at each tip, one between tips."""
    tips = _polar([0.0285], np.arange(0, 360, 72))
    hollows = _polar([0.0148], np.arange(36, 396, 72))
    across = np.column_stack((-tips[:, 1], tips[:, 0])) / 0.0285 * 0.0028
    outline = np.stack((tips - across, tips + across, hollows), axis=1).reshape(-1, 2)
    pieces = tuple((-1, (3 * ray - 1) % 15, 3 * ray, 3 * ray + 1, 3 * ray + 2) for ray in range(5))
    return Shape("star", (0.98, 0.80, 0.05), 5, outline, pieces, (0, 1, 3, 4, 6, 7, 9, 10, 12, 13))


def _moon() -> Shape:
    """A thick crescent: half a circle with a shallow bay."""
    outer = (0.0, 0.0165) + _polar([0.0275], np.linspace(180, 360, 9))
    across = np.linspace(0.0215, -0.0215, 7)
    inner = np.column_stack((across, 0.0095 + 0.0105 * (across / 0.0215) ** 2))
    pieces = ((0, 1, 2, 3, 13, 14, 15), (3, 4, 5, 11, 12, 13), (5, 6, 7, 8, 9, 10, 11))
    return Shape(
        "moon", (0.60, 0.15, 0.75), 1, np.concatenate((outer, inner)), pieces, (0, 3, 5, 8, 9, 15), eye=(0.0, -0.004)
    )


SHAPES: tuple[Shape, ...] = (_cube(), _cylinder(), _triangular_prism(), _star(), _moon())
"""In the order of RLBench's variations."""
