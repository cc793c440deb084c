"""However a recording writes the hand's pose, the same pose comes out."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey import schema
from lerobot_llakey.datasets.poses import state_reader
from lerobot_llakey.errors import LlakeyError

PLACES = np.array([[0.3, -0.1, 0.2], [0.4, 0.2, 0.1]])
TURNS = Rotation.from_rotvec([[3.0, 0.2, -0.1], [0.3, -1.2, 0.5]])
MATRICES = np.tile(np.eye(4), (2, 1, 1))
MATRICES[:, :3, :3], MATRICES[:, :3, 3] = TURNS.as_matrix(), PLACES
WXYZ = TURNS.as_quat(scalar_first=True)
EULER = TURNS.as_euler("xyz")
ENTRIES = [f"T_{row}{column}" for row in range(4) for column in range(4)]


def named(names: Sequence[str] | None, count: int) -> dict[str, Any]:
    return {"dtype": "float32", "shape": (count,), "names": names}


@pytest.mark.parametrize(
    ("names", "numbers", "options"),
    [
        (["ee.x", "ee.y", "ee.z", "ee.wx", "ee.wy", "ee.wz"], (PLACES, TURNS.as_rotvec()), {}),
        (["tcp_x", "tcp_y", "tcp_z", "tcp_rx", "tcp_ry", "tcp_rz"], (PLACES, TURNS.as_rotvec()),
         {"rotation": "rotation_vector"}),
        (["x", "y", "z", "rx", "ry", "rz"], (PLACES, EULER), {"rotation": "euler"}),
        (["x", "y", "z", "roll", "pitch", "yaw"], (PLACES, EULER), {}),
        (["roll", "pitch", "yaw", "z", "y", "x"], (np.rad2deg(EULER), PLACES[:, ::-1]), {"rotation": "euler_degrees"}),
        (["qw", "qx", "qy", "qz", "x", "y", "z"], (WXYZ, PLACES), {}),
        (ENTRIES, (MATRICES.reshape(2, 16),), {}),
        (None, (PLACES, WXYZ), {"rotation": "quaternion_wxyz"}),
        (None, (MATRICES.reshape(2, 16),), {"rotation": "matrix"}),
        (["a"] * 7, (PLACES, -TURNS.as_quat()), {"state_names": list(schema.POSE_NAMES)}),
    ],
)  # fmt: skip
def test_every_way_gives_the_pose(names: Any, numbers: Any, options: dict[str, Any]) -> None:
    states = np.concatenate((*numbers, [[0.25, 7.0], [0.75, 8.0]]), axis=1).astype(np.float32)
    further = ["ee.gripper_pos", "joint_1"]
    if "state_names" in options:
        options = options | {"state_names": options["state_names"] + further}
    given = None if names is None else [*names, *further]
    if names is None:
        options = options | {"gripper": f"number_{states.shape[1] - 2}"}
    reader = state_reader(named(given, states.shape[1]), **options)
    read = reader.read(states)
    assert reader.names[:8] == schema.HAND_NAMES
    np.testing.assert_allclose(read[:, :3], PLACES, atol=1e-6)
    assert (Rotation.from_quat(read[:, 3:7]).inv() * TURNS).magnitude().max() < 1e-5
    np.testing.assert_allclose(read[:, 7:], [[0.25, 7], [0.75, 8]], atol=1e-6)


@pytest.mark.parametrize(("closed", "opened"), [(0, 100), (0, 0.085), (255, 0)])
def test_openings_become_shares_and_a_hand_may_have_no_gripper(closed: float, opened: float) -> None:
    pose = np.concatenate((PLACES, TURNS.as_quat()), axis=1)
    states = np.column_stack((pose, [closed, (closed + opened) / 2]))
    names = [*schema.POSE_NAMES, "jaw"]
    reader = state_reader(named(names, 8), gripper="jaw", gripper_range=[closed, opened])
    np.testing.assert_allclose(reader.read(states)[:, 7], [0, 0.5])
    assert state_reader(named(names, 8)).names == tuple(names)
    assert state_reader(named(names, 8)).gripper is None


@pytest.mark.parametrize(
    ("names", "options", "message"),
    [
        (["x", "y", "z", "rx", "ry", "rz"], {}, "got rx, ry, rz; say which by --rotation"),
        (["x", "y", "z", "a", "b", "c"], {}, "got only x, y, z, a, b, c; name the numbers"),
        (["x", "y", "y", "wx", "wy", "wz"], {}, "'y'.*got it twice"),
        (["x", "y", "k", "wx", "wy", "wz"], {}, "'z'.*got only"),
        (["x", "y", "z", "wx", "wy", "wz"], {"rotation": "euler"}, "with --rotation=euler"),
        (["x", "y", "z", "wx", "wy", "wz"], {"rotation": "spin"}, "--rotation out of quaternion.*'spin'"),
        (["x", "y", "z", "wx", "wy", "wz"], {"gripper": "jaw"}, "--gripper to name.*'jaw'"),
        (["x", "y", "z", "wx", "wy", "wz"], {"gripper_range": [1, 1]}, r"\[closed, open\], got \[1, 1\]"),
        (None, {}, "a name for each of the 6 numbers"),
    ],
)
def test_what_names_do_not_tell_is_asked_for(names: Any, options: dict[str, Any], message: str) -> None:
    with pytest.raises(LlakeyError, match=message):
        state_reader(named(names, 6), **options)


def test_degrees_and_matrices_that_are_none_are_refused() -> None:
    degrees = np.concatenate((PLACES, np.rad2deg(EULER)), axis=1)
    with pytest.raises(LlakeyError, match=r"in radians.*euler_degrees"):
        state_reader(named(["x", "y", "z", "roll", "pitch", "yaw"], 6)).read(degrees)
    scaled = MATRICES.copy()
    scaled[1, :3, :3] *= 2
    with pytest.raises(LlakeyError, match=r"rigid matrices.*of row 1"):
        state_reader(named(ENTRIES, 16)).read(scaled.reshape(2, 16))
