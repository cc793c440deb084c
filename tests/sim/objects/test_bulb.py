"""Bulbs stand up again, and fit their sockets and nothing else does."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.mujoco_poses import body_pose, wxyz
from lerobot_llakey.sim.objects.bulb import (
    BULB_TOP,
    GLASS_HEIGHT,
    GLASS_RADIUS,
    TRAVEL,
    add_bulb,
    add_bulb_meshes,
    add_socket,
    facing,
    glass_middle,
    glass_profile,
)
from lerobot_llakey.sim.objects.screw_thread import ScrewThread
from lerobot_llakey.sim.scene import base_spec

SEAT = 0.02
SOCKET = np.array((0.5, 0.2, 0.0))


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    spec = base_spec()
    add_bulb_meshes(spec)
    for name in ("bulb", "other"):
        add_bulb(spec, name, (1, 1, 1, 1), (1, 0, 0, 1))
    socket = spec.worldbody.add_body(name="socket", pos=SOCKET)
    add_socket(socket, SEAT)
    ScrewThread("thread", "bulb", TRAVEL, 1.8).add(spec, socket, (0, 0, SEAT + TRAVEL), 0.0)
    return spec.compile()


def fall(model: mujoco.MjModel, poses: dict[str, Pose], seconds: float) -> dict[str, Pose]:
    data = mujoco.MjData(model)
    for name, pose in poses.items():
        data.joint(name).qpos[:] = (*pose.position, *wxyz(pose.quaternion))
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    return {name: body_pose(data, model.body(name).id) for name in poses}


def lean(pose: Pose) -> float:
    """Radians from upright."""
    return float(np.arccos(np.clip(pose.rotation.as_matrix()[2, 2], -1, 1)))


def aside(y: float) -> Pose:
    return Pose(np.array((0.5, y, 0.0)))


def test_a_bulb_stands_still(model: mujoco.MjModel) -> None:
    after = fall(model, {"bulb": aside(-0.1), "other": aside(-0.3)}, 2.0)
    for name, y in (("bulb", -0.1), ("other", -0.3)):
        assert lean(after[name]) < 0.02 and np.allclose(after[name].position, (0.5, y, 0.0), atol=0.001)


@pytest.mark.parametrize("tilt", [0.8, 1.57, 2.2, 3.0])
def test_a_bulb_that_falls_stands_up_again_nearby(model: mujoco.MjModel, tilt: float) -> None:
    dropped = Pose(np.array((0.5, -0.1, 0.15)), Rotation.from_euler("zy", (tilt, tilt)).as_quat())
    after = fall(model, {"bulb": dropped, "other": aside(-0.4)}, 2.0)["bulb"]
    assert lean(after) < 0.05 and abs(after.position[2]) < 0.002
    assert np.linalg.norm(after.position[:2] - dropped.position[:2]) < 0.25


@pytest.mark.parametrize("heading", [0.0, 0.4, 2.5])
def test_a_bulb_let_down_beside_the_axis_slips_into_its_socket(model: mujoco.MjModel, heading: float) -> None:
    beside = 0.004 * np.array((np.cos(heading), np.sin(heading), 0.0))
    start = Pose(SOCKET + beside + (0, 0, SEAT + 0.025))
    after = fall(model, {"bulb": start, "other": aside(-0.3)}, 1.0)["bulb"]
    assert np.linalg.norm(after.position - SOCKET - (0, 0, SEAT + TRAVEL)) < 0.004 and lean(after) < 0.15


def test_bulbs_do_not_pass_through_each_other(model: mujoco.MjModel) -> None:
    onto = Pose(np.array((0.515, -0.1, BULB_TOP + 0.01)))
    after = fall(model, {"bulb": onto, "other": aside(-0.1)}, 1.5)
    apart = np.linalg.norm(glass_middle(after["bulb"]) - glass_middle(after["other"]))
    assert apart > 2 * GLASS_RADIUS - 0.001 and abs(after["bulb"].position[2]) < 0.002


def test_the_glass_is_where_it_is_said_to_be(model: mujoco.MjModel) -> None:
    assert np.allclose(glass_middle(Pose(np.zeros(3), facing(0.7))), (0, 0, GLASS_HEIGHT))
    lying = Pose(np.zeros(3), Rotation.from_euler("y", np.pi / 2).as_quat())
    assert np.allclose(glass_middle(lying), (GLASS_HEIGHT, 0, 0))
    assert glass_profile()[-1] == pytest.approx((0.0, BULB_TOP), abs=0.001)
    assert np.allclose(np.linalg.norm(glass_profile(0.002) - (0, GLASS_HEIGHT), axis=1), GLASS_RADIUS + 0.0025)
