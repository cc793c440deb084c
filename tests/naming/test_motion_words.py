"""A segment's motion in words."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.naming.motion_words import motion_words

DOWN = Rotation.from_quat((1, 0, 0, 0))


def pose(x: float, y: float, z: float, turn: Rotation = DOWN) -> np.ndarray:
    return np.array([x, y, z, *turn.as_quat()])


@pytest.mark.parametrize(
    ("after", "opened", "words"),
    [
        (pose(0.4, 0, 0.32), (True, True), "moved up 12 cm, gripper stayed open"),
        (pose(0.4, 0.03, 0.1), None, "moved down 10 cm and left 3 cm"),
        (pose(0.3, -0.2, 0.205), (True, False), "moved right 20 cm and back 10 cm, gripper closed"),
        (pose(0.4, 0, 0.2), (False, True), "stayed where it was, gripper opened"),
        (
            pose(0.4, 0, 0.2, Rotation.from_euler("z", 90, degrees=True) * DOWN),
            None,
            "turned 90 degrees, counterclockwise as seen from above",
        ),
        (pose(0.4, 0, 0.2, Rotation.from_euler("y", -30, degrees=True) * DOWN), None, "turned 30 degrees, tilting"),
    ],
)
def test_motions_are_told(after: np.ndarray, opened: tuple[bool, bool] | None, words: str) -> None:
    assert motion_words(pose(0.4, 0, 0.2), after, opened) == words
    if opened is None:
        assert motion_words(pose(0.4, 0, 0.2), after * (*[1] * 3, *[-1] * 4), None) == words
