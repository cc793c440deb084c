"""Recordings of joints alone: the hand's pose by the arm's model, and all else as it was."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fakes_arm import JOINTS, NAMES, moved, recording, tip_poses, write_mjcf, write_urdf
from lerobot_llakey import schema
from lerobot_llakey.datasets.annotate import annotate, find_keyframes
from lerobot_llakey.datasets.joint_poses import ArmModel
from lerobot_llakey.errors import LlakeyError

TEXTS = ["move to the top of the cup", "grasp the cup", "raise the robotic arm"]


@pytest.mark.parametrize("write", [write_urdf, write_mjcf])
def test_joints_alone_are_annotated(write: Any, tmp_path: Path) -> None:
    source = recording(tmp_path / "source")
    arm = ArmModel(write(tmp_path / f"arm{'.urdf' if write is write_urdf else '.xml'}"), "tip", joint_unit="degrees")
    found = find_keyframes(source, arm=arm, gripper_range=[0, 100])
    assert [episode.keyframes for episode in found] == [[10, 18, 45]]
    copy = annotate(source, found, {0: TEXTS}, tmp_path / "copy", "me/demonstrations")
    feature = copy.features[schema.STATE]["names"]
    assert list(feature) == [*schema.POSE_NAMES, "gripper_opening", *NAMES[:5], "current"]
    states = np.array(copy.hf_dataset.with_format("numpy")[:][schema.STATE])
    places, turns = tip_poses(moved()[:, :5])
    assert np.linalg.norm(states[:, :3] - places, axis=1).max() < 1e-4
    assert np.rad2deg((Rotation.from_quat(states[:, 3:7]) * turns.inv()).magnitude().max()) < 0.01
    np.testing.assert_allclose(states[:, 7], moved()[:, 5] / 100, atol=1e-6)
    recorded = np.array(source.hf_dataset.with_format("numpy")[:][schema.STATE])
    np.testing.assert_allclose(states[:, 8:], recorded[:, [0, 1, 2, 3, 4, 6]], atol=1e-4)
    actions = np.array(copy.hf_dataset.with_format("numpy")[:][schema.ACTION])
    for frame, keyframe in ((0, 10), (9, 10), (10, 18), (30, 45), (45, 45)):
        np.testing.assert_allclose(actions[frame][:3], places[keyframe], atol=1e-4)
        assert actions[frame][7] == (keyframe == 10)


def test_numbers_that_are_named_joints_are_in_radians_then(tmp_path: Path) -> None:
    names = tuple(f"joint_{number}" for number in range(5))
    reader = ArmModel(write_urdf(tmp_path / "arm.urdf"), "tip", names, "degrees").reader(schema.vector(names))
    joints = np.rad2deg(moved()[:, :5])
    np.testing.assert_allclose(reader.read(joints)[:, 7:], np.deg2rad(joints))
    assert reader.names == (*schema.POSE_NAMES, *names)


def test_joints_are_found_in_any_order(tmp_path: Path) -> None:
    path, joints = write_urdf(tmp_path / "arm.urdf"), moved()[:, :5]
    plain = ArmModel(path, "tip").reader(schema.vector(JOINTS)).read(joints)
    turned = ArmModel(path, "tip").reader(schema.vector(JOINTS[::-1])).read(joints[:, ::-1])
    np.testing.assert_allclose(plain[:, :7], turned[:, :7])


@pytest.mark.parametrize(
    ("arm", "wording", "scale", "said"),
    [
        (
            {},
            {},
            57.3,
            r"shoulder_pan within its limits .*, -2 to 2 radians, got 17.19 in row 0; say --joint_unit=degrees",
        ),
        ({"joint_unit": "degrees"}, {}, 1.0, r"joints in degrees .*, got none beyond 0.8.*say --joint_unit=radians"),
        (
            {"joint_unit": "degrees"},
            {},
            300.0,
            r"-114.6 to 114.6 degrees, got .*no share of its travel from -100 to 100",
        ),
        ({"joint_unit": "turns"}, {}, 1.0, r"--joint_unit out of radians, degrees, got 'turns'"),
        ({"joint_names": ["a", "b"]}, {}, 1.0, r"--joint_names to name the 5 joints from base to tip \(shoulder_pan, "),
        (
            {"joint_names": [*JOINTS[:4], "wrist"]},
            {},
            1.0,
            r"got no wrist among shoulder_pan.pos, .*; give --joint_names",
        ),
        (
            {"joint_names": [*JOINTS[:4], JOINTS[0]]},
            {},
            1.0,
            r"different numbers as --joint_names, got .*name each once",
        ),
        ({"tip": "jaw"}, {}, 1.0, r"--tip before the gripper's joint, got jaw, which gripper.pos moves"),
        ({}, {"rotation": "euler"}, 1.0, r"got --urdf and --rotation=euler; leave one away"),
        ({}, {"state_names": [*JOINTS, "gripper", "z"]}, 1.0, r"joints alone in .* with --urdf, got the hand's z, too"),
    ],
)
def test_what_does_not_match_is_said_in_one_sentence(
    arm: dict[str, Any], wording: dict[str, Any], scale: float, said: str, tmp_path: Path
) -> None:
    model = ArmModel(write_urdf(tmp_path / "arm.urdf"), **{"tip": "tip"} | arm)
    with pytest.raises(LlakeyError, match=said) as raised:
        reader = model.reader(schema.vector(NAMES), gripper_range=[0, 100], **wording)
        rows = moved()
        reader.read(np.column_stack((rows[:, :5] * scale, rows[:, 5], rows[:, 5])))
    assert "\n" not in str(raised.value)


def test_joints_that_are_not_finite_are_refused(tmp_path: Path) -> None:
    joints = moved()[:, :5]
    joints[3, 1] = np.nan
    with pytest.raises(LlakeyError, match=r"finite joints in .*nan.* in row 3"):
        ArmModel(write_urdf(tmp_path / "arm.urdf"), "tip").reader(schema.vector(JOINTS)).read(joints)
