"""Bottles lie where they are laid, and the rack takes them one way round alone."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.mujoco_poses import body_pose, wxyz
from lerobot_llakey.sim.objects.wine import (
    LYING_HEIGHT,
    MIDDLE,
    SLOTS,
    add_bottle,
    add_bottle_meshes,
    add_rack,
    on_beam,
    slot_y,
)

NECK_FORWARD = Rotation.from_euler("y", np.pi / 2)
NECK_BACK = Rotation.from_euler("y", -np.pi / 2)


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    spec.option.timestep = 0.004
    spec.option.cone, spec.option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10
    spec.option.integrator, spec.option.noslip_iterations = mujoco.mjtIntegrator.mjINT_IMPLICITFAST, 3
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=(1, 1, 0.02), pos=(0, 0, -0.02), friction=(0.8, 0.005, 0.0001)
    )
    add_bottle_meshes(spec)
    add_bottle(spec, "bottle", (0.8, 0.1, 0.1, 1.0))
    add_rack(spec, "rack")
    return spec.compile()


def settle(model: mujoco.MjModel, middle: tuple[float, float, float], rotation: Rotation, seconds: float = 1.5) -> Pose:
    """Let a bottle go whose middle is somewhere; where it comes to rest."""
    data = mujoco.MjData(model)
    data.qpos[:3] = np.array(middle) - rotation.apply((0, 0, MIDDLE))
    data.qpos[3:7] = wxyz(rotation.as_quat())
    mujoco.mj_step(model, data, round(seconds / model.opt.timestep))
    assert np.abs(data.qvel).max() < 0.1
    return body_pose(data, model.body("bottle").id)


@pytest.mark.parametrize("slot", SLOTS)
@pytest.mark.parametrize(("aside", "turned"), [(0.0, 0.0), (0.012, 0.1), (-0.012, -0.1)])
def test_a_bottle_let_go_above_a_cradle_slides_into_it(
    model: mujoco.MjModel, slot: str, aside: float, turned: float
) -> None:
    start = (0.0, slot_y(slot) + aside, LYING_HEIGHT + 0.015)
    bottle = settle(model, start, Rotation.from_euler("z", turned) * NECK_FORWARD)
    miss = bottle.apply(np.array((0, 0, MIDDLE))) - (0, slot_y(slot), LYING_HEIGHT)
    assert np.abs(miss[1:]).max() < 0.004 and abs(miss[0]) < 0.02
    assert bottle.rotation.as_matrix()[0, 2] > np.cos(np.deg2rad(3))


def test_a_bottle_the_wrong_way_round_lies_askew(model: mujoco.MjModel) -> None:
    bottle = settle(model, (0.0, 0.0, LYING_HEIGHT + 0.02), NECK_BACK)
    assert abs(bottle.rotation.as_matrix()[2, 2]) > np.sin(np.deg2rad(8))


def test_a_bottle_stands_and_a_dropped_one_stays_near(model: mujoco.MjModel) -> None:
    upright = settle(model, (0.4, 0.0, MIDDLE), Rotation.identity())
    assert upright.rotation.as_matrix()[2, 2] > 0.999
    for tilt in (60, 90):
        dropped = settle(model, (0.4, 0.0, 0.2), Rotation.from_euler("zy", (30, tilt), degrees=True), seconds=3.0)
        assert np.linalg.norm(dropped.position[:2] - (0.4, 0.0)) < 0.25


def test_the_beams_are_in_the_way_of_fingers_where_they_are() -> None:
    sides = np.array(((0.0, 0.045, 0.04), (0.0, -0.045, 0.04)))
    assert not on_beam(sides)
    for x in (-0.063, 0.066):
        assert on_beam(sides + (x, 0, 0))
        assert not on_beam(sides + (x, 0, 0.05)) and not on_beam(sides + (x, 0.3, 0))
