"""Shapes stand by themselves, look the same after the turns they claim, and fit no hole but their own."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.sim.objects.shapes import BODY_HEIGHT, HEIGHT, SHAPES, Shape, add_shape, extent, widened

STEP = 0.003


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    spec.option.timestep = 0.004
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=(1, 1, 0.1), pos=(0, 0, -0.1))
    for shape in SHAPES:
        add_shape(spec, shape)
    return spec.compile()


def area(outline: np.ndarray) -> float:
    after = np.roll(outline, -1, axis=0)
    return float((outline[:, 0] * after[:, 1] - outline[:, 1] * after[:, 0]).sum() / 2)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.body)
def test_the_eye_sees_every_edge(shape: Shape) -> None:
    for outline in (shape.outline, widened(shape.outline, 0.006)):
        seen = outline - shape.eye
        after = np.roll(seen, -1, axis=0)
        assert (seen[:, 0] * after[:, 1] - seen[:, 1] * after[:, 0] > 0).all()


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.body)
def test_the_pieces_make_up_the_outline(shape: Shape) -> None:
    corners = np.concatenate((shape.outline, [(0.0, 0.0)]))
    assert sum(area(corners[list(piece)]) for piece in shape.pieces) == pytest.approx(area(shape.outline), rel=1e-6)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.body)
def test_a_shape_looks_the_same_after_each_of_its_turns(shape: Shape) -> None:
    turns = shape.fold or 16
    angle = 2 * np.pi / turns
    turned = shape.outline @ np.array(((np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))))
    nearest = np.linalg.norm(turned[:, None] - shape.outline[None], axis=2).min(axis=1)
    assert nearest.max() < 1e-9


def test_a_square_is_widened_on_every_side() -> None:
    square = np.array(((1, -1), (1, 1), (-1, 1), (-1, -1)))
    np.testing.assert_allclose(widened(square, 0.5), 1.5 * square)


def test_extent_of_a_turned_shape() -> None:
    cube = SHAPES[0]
    assert extent(cube, Rotation.identity()) == pytest.approx(0.0)
    assert extent(cube, Rotation.from_euler("x", np.pi)) == pytest.approx(-HEIGHT)
    assert extent(cube, Rotation.from_euler("x", np.pi / 2)) == pytest.approx(-0.02)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.body)
@pytest.mark.parametrize("tilt", [0.0, 0.6, 1.3])
def test_a_shape_rights_itself(model: mujoco.MjModel, shape: Shape, tilt: float) -> None:
    data = mujoco.MjData(model)
    for index, other in enumerate(SHAPES):
        data.joint(other.body).qpos[:3] = (0.2 * index, 0.0, 0.0)
    x, y, z, w = Rotation.from_euler("ZX", (0.4, tilt)).as_quat()
    data.joint(shape.body).qpos[2:] = (0.04, w, x, y, z)
    for _ in range(250):
        mujoco.mj_step(model, data)
    body = data.body(shape.body)
    assert body.xmat[8] > np.cos(0.05) and abs(body.xpos[2]) < 0.002
    assert np.abs(data.joint(shape.body).qvel).max() < 0.02


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.body)
def test_nothing_but_the_bar_is_above_the_body(model: mujoco.MjModel, shape: Shape) -> None:
    body = model.body(shape.body)
    geoms = range(body.geomadr[0], body.geomadr[0] + body.geomnum[0])
    bars = [g for g in geoms if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_BOX]
    assert len(bars) == 1
    assert model.geom_pos[bars[0], 2] - model.geom_size[bars[0], 2] == pytest.approx(BODY_HEIGHT)
