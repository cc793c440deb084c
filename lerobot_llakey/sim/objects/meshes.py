"""Meshes made in code: bodies of revolution and extruded outlines."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from lerobot_llakey.errors import LlakeyError


def revolve(profile: ArrayLike, sides: int = 24) -> tuple[np.ndarray, np.ndarray]:
    """A closed surface of revolution about z.

    Args:
        profile: (N, 2) radius and height in metres along the outline, N >= 2. Traced upwards it gives a solid; where it
            comes back down at smaller radii, a hollow one. Ends off the axis are closed by a disc.
        sides: corners of each ring.

    Returns:
        Vertices (M, 3) in metres and triangles (F, 3) that face outwards.

    Raises:
        LlakeyError: if the profile has another shape, a radius is negative, or there are fewer than three sides.
    """
    outline = np.asarray(profile, dtype=np.float64)
    if outline.ndim != 2 or outline.shape[1] != 2 or len(outline) < 2 or outline[:, 0].min() < 0 or sides < 3:
        raise LlakeyError(
            f"Expected a profile (N, 2) of N >= 2 radii >= 0 and heights, and 3 sides or more, got {outline.shape} "
            f"and {sides}; trace the outline upwards from the axis."
        )
    angles = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    circle = np.column_stack((np.cos(angles), np.sin(angles)))
    rings = np.concatenate([np.column_stack((r * circle, np.full(sides, z))) for r, z in outline])
    following = np.roll(np.arange(sides), -1)
    faces = []
    for ring in range(len(outline) - 1):
        low, high = ring * sides + np.arange(sides), (ring + 1) * sides + np.arange(sides)
        low_next, high_next = ring * sides + following, (ring + 1) * sides + following
        faces += [np.column_stack((low, low_next, high_next)), np.column_stack((low, high_next, high))]
    caps = np.array([[0, 0, outline[0, 1]], [0, 0, outline[-1, 1]]])
    bottom, top = len(rings), len(rings) + 1
    last = (len(outline) - 1) * sides
    faces.append(np.column_stack((np.full(sides, bottom), following, np.arange(sides))))
    faces.append(np.column_stack((np.full(sides, top), last + np.arange(sides), last + following)))
    vertices, triangles = np.concatenate((rings, caps)), np.concatenate(faces)
    return _without_slivers(vertices, triangles)


def extrude(polygon: ArrayLike, height: float) -> tuple[np.ndarray, np.ndarray]:
    """A prism over an outline that its own origin sees entirely (a star is such a one).

    Args:
        polygon: (N, 2) corners in metres, counter-clockwise around the origin, N >= 3.
        height: metres along z, from 0.

    Returns:
        Vertices (2 N + 2, 3) and triangles (4 N, 3) that face outwards.

    Raises:
        LlakeyError: if the polygon has another shape, the height is not positive, or the origin does not see each edge.
    """
    outline = np.asarray(polygon, dtype=np.float64)
    if outline.ndim != 2 or outline.shape[1] != 2 or len(outline) < 3 or height <= 0:
        raise LlakeyError(
            f"Expected a polygon (N, 2) of N >= 3 corners and a height above 0, got {outline.shape} and {height}."
        )
    after = np.roll(outline, -1, axis=0)
    if (outline[:, 0] * after[:, 1] - outline[:, 1] * after[:, 0] <= 0).any():
        raise LlakeyError(
            "Expected corners counter-clockwise around an origin that sees every edge; move or reverse it."
        )
    count = len(outline)
    lower = np.column_stack((outline, np.zeros(count)))
    caps = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, height]])
    vertices = np.concatenate((lower, lower + (0, 0, height), caps))
    first, second = np.arange(count), np.roll(np.arange(count), -1)
    bottom, top = np.full(count, 2 * count), np.full(count, 2 * count + 1)
    faces = (
        np.column_stack((first, second, second + count)),
        np.column_stack((first, second + count, first + count)),
        np.column_stack((bottom, second, first)),
        np.column_stack((top, first + count, second + count)),
    )
    return vertices, np.concatenate(faces)


def add_mesh(spec: mujoco.MjSpec, name: str, vertices: np.ndarray, faces: np.ndarray | None = None) -> str:
    """Add a mesh asset and return its name.

    A geom that uses it is drawn by its faces (by its hull where None) and collides as its convex hull in any case.
    MuJoCo moves a mesh's origin to its centre of mass but draws and collides it where the vertices say.

    Args:
        spec: the scene.
        name: of the mesh.
        vertices: (M, 3) in metres.
        faces: (F, 3) indices, counter-clockwise seen from outside.
    """
    mesh = spec.add_mesh(name=name, uservert=np.asarray(vertices, dtype=np.float64).ravel())
    if faces is not None:
        mesh.userface = np.asarray(faces, dtype=np.int32).ravel()
    return name


def _without_slivers(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same surface with coinciding corners (a ring of radius 0) joined and empty triangles left out."""
    unique, index = np.unique(np.round(vertices, 9), axis=0, return_inverse=True)
    joined = index.reshape(-1)[faces]
    a, b, c = joined.T
    return unique, joined[(a != b) & (b != c) & (c != a)]
