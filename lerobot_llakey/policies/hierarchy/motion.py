"""How far the hand is from a pose: states (15,) and actions (9,) both begin with metres and a quaternion xyzw."""

from __future__ import annotations

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.geometry import canonical_quaternion


def distance(first: np.ndarray, second: np.ndarray) -> float:
    """Metres between the positions of two states or actions."""
    return float(np.linalg.norm(np.subtract(first[schema.POSITION], second[schema.POSITION], dtype=np.float64)))


def turned(first: np.ndarray, second: np.ndarray) -> float:
    """Degrees, 0 to 180, between the orientations of two states or actions.

    Raises:
        LlakeyError: if a quaternion is not four finite numbers of non-zero length.
    """
    quaternions = [canonical_quaternion(pose[schema.QUATERNION]) for pose in (first, second)]
    return float(np.degrees(2 * np.arccos(min(1.0, abs(float(quaternions[0] @ quaternions[1]))))))
