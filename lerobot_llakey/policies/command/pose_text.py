"""Poses as texts of whole numbers: the answers of direct actions, and the hand's pose in a prompt.

A text holds x, y, z within the workspace, the quaternion, the gripper, and for an action the collision flag. Direct
actions are the paper's comparison after RT-2 (section IV-B). RT-2 uses Euler angles; here they would wrap at the most
common orientation, a hand that points down, and lose an axis at the next, a hand that points ahead. So the rotation is
the quaternion, w >= 0, from a hand that points straight down, which is smooth unless the hand points up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import DOWN, canonical_quaternion

DIGITS = 3
_FLAGS = 2
"""Values of the gripper and of the collision flag."""


@dataclass(frozen=True)
class PoseText:
    """Actions to texts and back, and hands to texts.

    Every number has three digits, so no number is a prefix of another.

    Attributes:
        bins: number of values of a position or quaternion entry.
        workspace: bounds in metres of x, y and z.

    Raises:
        LlakeyError: if the bins are too few or too many, or a bound of the workspace is upside down.
    """

    bins: int = 256
    workspace: Sequence[Sequence[float]] = schema.WORKSPACE

    def __post_init__(self) -> None:
        if not 2 <= self.bins <= 10**DIGITS:
            raise LlakeyError(f"Expected `action_bins` from 2 to {10**DIGITS}, got {self.bins}; 256 is RT-2's number.")
        if len(self.workspace) != 3 or any(len(pair) != 2 or pair[0] >= pair[1] for pair in self.workspace):
            raise LlakeyError(
                f"Expected `workspace` as three (low, high) pairs in metres, got {self.workspace}; correct it."
            )

    @property
    def bounds(self) -> np.ndarray:
        """(7, 2) lowest and highest value of x, y, z, and of the quaternion's x, y, z, w."""
        return np.array([*self.workspace, (-1, 1), (-1, 1), (-1, 1), (0, 1)], dtype=np.float64)

    @property
    def sizes(self) -> list[int]:
        """Number of values of each of the nine numbers."""
        return [self.bins] * 7 + [_FLAGS] * 2

    @property
    def numbers(self) -> list[str]:
        """Every number as text, which a vocabulary must contain."""
        return [f"{value:0{DIGITS}d}" for value in range(max(self.bins, _FLAGS))]

    def encode(self, action: np.ndarray) -> str:
        """The text of an action (9,) in the data contract; positions outside the workspace move to its edge."""
        flags = (action[[schema.GRIPPER, schema.IGNORE_COLLISION]] > 0.5).astype(int)
        return " ".join(self.numbers[number] for number in (*self._pose(action), *flags))

    def encode_hand(self, hand: np.ndarray) -> str:
        """The text of a hand (8,): its pose, and the gripper's opening."""
        opening = np.floor(hand[schema.GRIPPER] * self.bins).clip(0, self.bins - 1).astype(int)
        return " ".join(self.numbers[number] for number in (*self._pose(hand), opening))

    def _pose(self, row: np.ndarray) -> np.ndarray:
        """The seven numbers of the pose in an action or a hand."""
        rotation = Rotation.from_quat(DOWN).inv() * Rotation.from_quat(row[schema.QUATERNION])
        values = np.concatenate((row[schema.POSITION], canonical_quaternion(rotation.as_quat())))
        low, high = self.bounds.T
        return np.floor((values - low) / (high - low) * self.bins).clip(0, self.bins - 1).astype(int)

    def decode(self, text: str) -> np.ndarray:
        """The action (9,) float32 of a text: the middles of its bins, and a unit quaternion xyzw with w >= 0.

        Raises:
            LlakeyError: if the text is not nine legal numbers.
        """
        words = text.split()
        numbers = [int(word) for word in words if word.isdecimal()]
        legal = all(number < size for number, size in zip(numbers, self.sizes, strict=False))
        if not len(words) == len(numbers) == len(self.sizes) or not legal:
            raise LlakeyError(
                f"Expected {len(self.sizes)} numbers below {self.sizes}, got {text!r}; keep constrain=true, which "
                "allows no others."
            )
        low, high = self.bounds.T
        values = low + (np.array(numbers[:7]) + 0.5) / self.bins * (high - low)
        rotation = Rotation.from_quat(DOWN) * Rotation.from_quat(values[3:])
        action = np.empty(schema.ACTION_DIM, dtype=np.float32)
        action[schema.POSITION] = values[:3]
        action[schema.QUATERNION] = canonical_quaternion(rotation.as_quat())
        action[[schema.GRIPPER, schema.IGNORE_COLLISION]] = numbers[7:]
        return action
