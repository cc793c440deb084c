"""A box whose top has one hole for each of five shapes, with a compartment under each hole."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from lerobot_llakey.sim.objects.meshes import add_mesh
from lerobot_llakey.sim.objects.shapes import SHAPES, TOUCH, Shape, widened

BODY = "shape_sorter"
HALF_SIZE = (0.068, 0.095)
PLATE_BOTTOM, PLATE_TOP = 0.054, 0.062
_CLEARANCE, _CHAMFER = 0.0025, 0.0035
"""Metres between a shape and its hole all around, and width of the hole's sloping edge."""
_THROAT_TOP = PLATE_TOP - 0.004
_WALL = 0.001
"""Half the thickness of the walls, metres."""
_PALE = (0.82, 0.79, 0.70, 1.0)
_DARK = (0.13, 0.12, 0.12, 1.0)
_ROWS, _BACK, _FRONT = -0.003, (0.027, -0.022), (0.0,)
"""Where the compartments part, metres: the two rows along x, the three behind and the two in front along y."""


@dataclass(frozen=True)
class Compartment:
    """A rectangle of the sorter, seen from above in its frame.

    Attributes:
        low: (2,) smallest x and y, metres.
        high: (2,) largest x and y, metres.
    """

    low: tuple[float, float]
    high: tuple[float, float]

    def contains(self, point: np.ndarray) -> bool:
        return bool((point[:2] > self.low).all() and (point[:2] < self.high).all())


_X, _Y = HALF_SIZE
COMPARTMENTS: dict[str, Compartment] = {
    "triangular prism": Compartment((_ROWS, _BACK[0]), (_X, _Y)),
    "moon": Compartment((_ROWS, _BACK[1]), (_X, _BACK[0])),
    "star": Compartment((_ROWS, -_Y), (_X, _BACK[1])),
    "cylinder": Compartment((-_X, _FRONT[0]), (_ROWS, _Y)),
    "cube": Compartment((-_X, -_Y), (_ROWS, _FRONT[0])),
}


def hole(shape: Shape) -> np.ndarray:
    """(2,) place in the sorter's frame of a shape's origin when it is right over its hole, unturned."""
    compartment = COMPARTMENTS[shape.name]
    middle = np.add(compartment.low, compartment.high) / 2
    return middle - (shape.outline.min(axis=0) + shape.outline.max(axis=0)) / 2


def add_shape_sorter(spec: mujoco.MjSpec) -> None:
    """Add the sorter as a fixed body whose origin is the middle of its base."""
    sorter = spec.worldbody.add_body(name=BODY)
    box = mujoco.mjtGeom.mjGEOM_BOX
    sorter.add_geom(type=box, size=(_X - _WALL, _Y - _WALL, _WALL), pos=(0, 0, _WALL), rgba=_DARK, **TOUCH)
    for x, y, colour in ((_X, _Y, _PALE), (_X - 2 * _WALL, _Y - 2 * _WALL, _DARK)):
        # The outer walls are lined with dark ones, so that the holes look dark.
        for side in (-1, 1):
            _add_wall(sorter, (side * (x - _WALL), -y), (side * (x - _WALL), y), colour)
            _add_wall(sorter, (-x, side * (y - _WALL)), (x, side * (y - _WALL)), colour)
    # The partitions end inside the walls.
    x, y = _X - 2 * _WALL, _Y - 2 * _WALL
    _add_wall(sorter, (_ROWS, -y), (_ROWS, y), _DARK)
    for row in _BACK:
        _add_wall(sorter, (_ROWS, row), (x, row), _DARK)
    for row in _FRONT:
        _add_wall(sorter, (-x, row), (_ROWS, row), _DARK)
    for shape in SHAPES:
        _add_hole(spec, sorter, shape)


def _add_wall(
    sorter: mujoco.MjsBody,
    start: tuple[float, float],
    end: tuple[float, float],
    colour: tuple[float, float, float, float],
) -> None:
    """An upright wall between two points on a line along x or y."""
    half = np.maximum(np.abs(np.subtract(end, start)) / 2, _WALL)
    middle = np.add(start, end) / 2
    sorter.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=(*half, PLATE_BOTTOM / 2),
        pos=(*middle, PLATE_BOTTOM / 2),
        rgba=colour,
        **TOUCH,
    )


def _add_hole(spec: mujoco.MjSpec, sorter: mujoco.MjsBody, shape: Shape) -> None:
    """The top of one compartment, as a convex piece outwards from every edge of the hole."""
    compartment, place = COMPARTMENTS[shape.name], hole(shape)
    throat, mouth = (place + widened(shape.outline, _CLEARANCE + more) for more in (0.0, _CHAMFER))
    eye = place + shape.eye
    count = len(throat)
    for index in range(count):
        edge = [index, (index + 1) % count]
        border = _border(eye, mouth[edge], compartment)
        levels = (
            (np.concatenate((throat[edge], border)), PLATE_BOTTOM),
            (np.concatenate((throat[edge], border)), _THROAT_TOP),
            (np.concatenate((mouth[edge], border)), PLATE_TOP),
        )
        vertices = np.concatenate([np.column_stack((ring, np.full(len(ring), z))) for ring, z in levels])
        mesh = add_mesh(spec, f"{BODY}_{shape.body}_{index}", vertices)
        sorter.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh, rgba=_PALE, **TOUCH)


def _border(eye: np.ndarray, edge: np.ndarray, compartment: Compartment) -> np.ndarray:
    """(2 or more, 2) points of the compartment's border that the eye sees through an edge (2, 2)."""
    rays = edge - eye
    with np.errstate(divide="ignore"):
        reach = np.maximum((np.array(compartment.low) - eye) / rays, (np.array(compartment.high) - eye) / rays)
    ends = eye + reach.min(axis=1, keepdims=True) * rays
    (low_x, low_y), (high_x, high_y) = compartment.low, compartment.high
    corners = np.array([(x, y) for x in (low_x, high_x) for y in (low_y, high_y)])
    seen = corners - eye
    after = rays[0, 0] * seen[:, 1] - rays[0, 1] * seen[:, 0] > 0
    before = seen[:, 0] * rays[1, 1] - seen[:, 1] * rays[1, 0] > 0
    return np.concatenate((ends, corners[after & before]))
