"""Jars and lids."""

import mujoco
import numpy as np
import pytest

from lerobot_llakey.sim.mujoco_poses import about_z
from lerobot_llakey.sim.objects.jar import JAR_TOP, LID_DEPTH, add_jar, add_jar_tip, add_lid
from lerobot_llakey.sim.scene import base_spec


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    spec = base_spec()
    add_jar_tip(spec)
    add_jar(spec, "jar")
    add_lid(spec, 0.5)
    return spec.compile()


@pytest.mark.parametrize("tilt", [1.2, np.pi / 2, 2.5])
def test_a_fallen_lid_rights_itself(model: mujoco.MjModel, tilt: float) -> None:
    data = mujoco.MjData(model)
    data.joint("lid").qpos[:] = (0.5, 0.3, 0.06, np.cos(tilt / 2), np.sin(tilt / 2), 0, 0)
    for _ in range(750):
        mujoco.mj_step(model, data)
    assert data.body("lid").xmat[8] > 0.95
    assert data.body("lid").xpos[2] < 0.01


def test_a_lid_fits_over_the_jar(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    data.joint("lid").qpos[:] = (0, 0, JAR_TOP - LID_DEPTH + 0.001, *about_z(0.0))
    mujoco.mj_forward(model, data)
    names = [{model.body(model.geom_bodyid[geom]).name for geom in pair} for pair in data.contact.geom]
    deep = [pair for pair, gap in zip(names, data.contact.dist, strict=True) if pair == {"jar", "lid"} and gap < -1e-4]
    assert not deep
