"""Forward kinematics of models whose meshes are missing, against the product of transforms."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fakes_arm import JOINTS, LIMIT, tip_poses, write_mjcf, write_urdf
from lerobot_llakey.datasets.kinematics import read_kinematics
from lerobot_llakey.errors import LlakeyError


@pytest.mark.parametrize(("write", "name"), [(write_urdf, "arm.urdf"), (write_mjcf, "arm.xml")])
def test_poses_are_those_of_the_product_of_transforms(write: Callable[[Path], Path], name: str, tmp_path: Path) -> None:
    arm = read_kinematics(write(tmp_path / name), "tip")
    assert arm.joints == JOINTS and arm.turning.all()
    np.testing.assert_allclose(arm.limits, [(-LIMIT, LIMIT)] * 5, atol=1e-9)
    joints = np.random.default_rng(0).uniform(-LIMIT, LIMIT, (200, 5))
    poses = arm.poses(joints)
    places, turns = tip_poses(joints)
    assert np.linalg.norm(poses[:, :3] - places, axis=1).max() < 1e-4
    assert np.rad2deg((Rotation.from_quat(poses[:, 3:]) * turns.inv()).magnitude().max()) < 0.01
    assert np.ptp(places, axis=0).min() > 0.1


def test_a_link_on_the_way_has_the_joints_before_it_alone(tmp_path: Path) -> None:
    assert read_kinematics(write_urdf(tmp_path / "arm.urdf"), "link_2").joints == JOINTS[:3]


def test_a_joint_that_slides_is_in_metres(tmp_path: Path) -> None:
    path = tmp_path / "lift.xml"
    path.write_text('<mujoco><worldbody><body name="lift"><joint name="up" type="slide"/></body></worldbody></mujoco>')
    arm = read_kinematics(path, "lift")
    assert not arm.turning.any() and np.isinf(arm.limits).all()
    np.testing.assert_allclose(arm.poses(np.array([[0.25]]))[0], (0, 0, 0.25, 0, 0, 0, 1), atol=1e-12)


@pytest.mark.parametrize(
    ("tip", "said"),
    [
        ("tipp", r"--tip to name a link, body or site of .*arm.urdf, got 'tipp'; the nearest are tip"),
        ("Q7", r"got 'Q7'; there are .*link_4, jaw, tip"),
        ("base", r"named joints that turn or slide between the base of .* and base, got none; give"),
    ],
)
def test_a_tip_that_does_not_fit_is_said(tip: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(LlakeyError, match=said):
        read_kinematics(write_urdf(tmp_path / "arm.urdf"), tip)


def test_a_base_that_floats_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "floating.xml"
    path.write_text('<mujoco><worldbody><body name="hand"><freejoint name="root"/></body></worldbody></mujoco>')
    with pytest.raises(LlakeyError, match=r"got root among them; give the model of an arm whose base stands still"):
        read_kinematics(path, "hand")


def test_what_is_no_model_is_said_in_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text("<robot><link")
    with pytest.raises(LlakeyError, match="Expected a readable URDF or MJCF file"):
        read_kinematics(tmp_path / "arm.urdf", "tip")
    with pytest.raises(FileNotFoundError, match="Expected a URDF or MJCF file"):
        read_kinematics(tmp_path / "none.urdf", "tip")
