"""Meshes made in code."""

import mujoco
import numpy as np
import pytest

from lerobot_llakey.sim.objects.meshes import add_mesh, extrude, revolve


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Signed volume: positive where all triangles face outwards."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return float((np.cross(a, b) * c).sum() / 6)


def closed(faces: np.ndarray) -> bool:
    """Whether every edge is met once in each direction."""
    edges = np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]])).tolist()
    directed = {tuple(edge) for edge in edges}
    return len(directed) == len(edges) and all((b, a) in directed for a, b in directed)


@pytest.mark.parametrize(
    ("profile", "expected"),
    [
        ([(0.02, 0.0), (0.02, 0.05)], np.pi * 0.02**2 * 0.05),
        ([(0.0, 0.0), (0.02, 0.0), (0.0, 0.06)], np.pi * 0.02**2 * 0.06 / 3),
        ([(0.0, 0.0), (0.03, 0.0), (0.03, 0.05), (0.02, 0.05), (0.02, 0.01), (0.0, 0.01)],
         np.pi * (0.03**2 * 0.05 - 0.02**2 * 0.04)),
    ],
    ids=("cylinder", "cone", "cup"),
)  # fmt: skip
def test_revolved_solids_have_their_volume(profile: list[tuple[float, float]], expected: float) -> None:
    vertices, faces = revolve(profile, sides=96)
    assert volume(vertices, faces) == pytest.approx(expected, rel=0.005)
    assert closed(faces)


def test_extruded_star_has_its_volume() -> None:
    angles = np.arange(10) * np.pi / 5
    star = np.where(np.arange(10) % 2, 0.01, 0.02)[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    vertices, faces = extrude(star, 0.03)
    assert volume(vertices, faces) == pytest.approx(5 * 0.01 * 0.02 * np.sin(np.pi / 5) * 0.03)
    assert closed(faces)


def test_mesh_stands_where_its_vertices_say() -> None:
    spec = mujoco.MjSpec()
    vertices, faces = revolve([(0.02, 0.1), (0.01, 0.3)])
    name = add_mesh(spec, "cone", vertices, faces)
    spec.worldbody.add_geom(name="cone", type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    drawn = model.mesh_vert @ data.geom_xmat[0].reshape(3, 3).T + data.geom_xpos[0]
    assert drawn.min(axis=0) == pytest.approx(vertices.min(axis=0), abs=1e-6)
    assert drawn.max(axis=0) == pytest.approx(vertices.max(axis=0), abs=1e-6)


@pytest.mark.parametrize(
    ("profile", "sides"), [([(0.1, 0.0)], 8), ([(-0.1, 0.0), (0.1, 1.0)], 8), ([(1, 0), (1, 1)], 2)]
)
def test_impossible_profiles_are_refused(profile: list[tuple[float, float]], sides: int) -> None:
    with pytest.raises(ValueError, match="profile"):
        revolve(profile, sides)


def test_outline_that_its_origin_does_not_see_is_refused() -> None:
    with pytest.raises(ValueError, match="counter-clockwise"):
        extrude([(0, 0), (0, 1), (1, 0)], 1.0)
    with pytest.raises(ValueError, match="height"):
        extrude([(1, 0), (0, 1), (-1, -1)], 0.0)
