"""Each hole lets its own shape through and no other."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.sim.objects.shape_sorter import COMPARTMENTS, HALF_SIZE, PLATE_TOP, add_shape_sorter, hole
from lerobot_llakey.sim.objects.shapes import SHAPES, Shape, add_shape


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    spec.option.timestep = 0.004
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=(1, 1, 0.1), pos=(0, 0, -0.1))
    add_shape_sorter(spec)
    for shape in SHAPES:
        add_shape(spec, shape)
    return spec.compile()


def fall(model: mujoco.MjModel, shape: Shape, into: Shape, yaw: float, beside: tuple[float, float]) -> float:
    """Height of the shape after it was let go over a hole."""
    data = mujoco.MjData(model)
    for index, other in enumerate(SHAPES):
        data.joint(other.body).qpos[:3] = (0.2 * index - 0.4, 0.4, 0.0)
    x, y, z, w = Rotation.from_euler("z", yaw).as_quat()
    data.joint(shape.body).qpos[:] = (*(hole(into) + beside), PLATE_TOP + 0.003, w, x, y, z)
    for _ in range(200):
        mujoco.mj_step(model, data)
    return float(data.body(shape.body).xpos[2])


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.body)
@pytest.mark.parametrize(("yaw", "beside"), [(0.0, (0.0, 0.0)), (0.1, (0.003, -0.003)), (-0.1, (-0.003, 0.003))])
def test_a_shape_falls_through_its_own_hole(
    model: mujoco.MjModel, shape: Shape, yaw: float, beside: tuple[float, float]
) -> None:
    assert fall(model, shape, shape, yaw, beside) < 0.01


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.body)
def test_a_shape_falls_through_no_other_hole(model: mujoco.MjModel, shape: Shape) -> None:
    for other in SHAPES:
        if other is not shape:
            assert min(fall(model, shape, other, yaw, (0.0, 0.0)) for yaw in (0.0, 0.7)) > 0.04, other.name


def test_every_hole_is_in_its_compartment() -> None:
    for shape in SHAPES:
        compartment = COMPARTMENTS[shape.name]
        corners = shape.outline + hole(shape)
        assert all(compartment.contains(corner) for corner in corners)
        assert (np.abs([compartment.low, compartment.high]) <= HALF_SIZE).all()
        assert [name for name, other in COMPARTMENTS.items() if other.contains(hole(shape))] == [shape.name]
