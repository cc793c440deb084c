"""Quaternions change order at the simulator's edge only."""

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.sim.mujoco_poses import about_z, body_pose, site_pose, wxyz, xyzw
from lerobot_llakey.sim.simulation import Simulation


def test_orders_are_inverse() -> None:
    quaternion = np.array([0.1, 0.2, 0.3, 0.9])
    assert np.allclose(wxyz(quaternion), (0.9, 0.1, 0.2, 0.3))
    assert np.allclose(xyzw(wxyz(quaternion)), quaternion)


def test_site_lies_on_its_body(simulation: Simulation) -> None:
    world = simulation.world
    model, data = world.model, world.data
    simulation.reset(0)
    site = model.site("top_handle")
    expected = body_pose(data, model.body("top_drawer").id).apply(site.pos)
    assert np.allclose(site_pose(data, site.id).position, expected)


def test_a_turn_about_z_is_what_scipy_says() -> None:
    np.testing.assert_allclose(xyzw(np.array(about_z(0.7))), Rotation.from_euler("z", 0.7).as_quat())
