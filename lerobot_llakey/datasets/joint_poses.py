"""The hand's pose where a recording holds joints alone, by the forward kinematics of the arm's model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.datasets.kinematics import Kinematics, read_kinematics
from lerobot_llakey.datasets.poses import StateReader, recorded_names, state_reader
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.hand import plain_name

UNITS = ("radians", "degrees")
"""What ``--joint_unit`` may say of joints that turn; joints that slide are in metres."""
_BEYOND = np.deg2rad(30)
"""How far beyond its limit a joint may be recorded: calibrations differ, units differ by far more."""
_FAR = 4 * np.pi
"""Where a model has no limit."""


@dataclass(frozen=True)
class JointReader:
    """Where a recorded state's joints stand, and what they make of the hand.

    Attributes:
        kinematics: of the arm.
        places: of its joints, from base to tip, among the state's numbers.
        degrees: whether those that turn are recorded in degrees.
        named_joint: (N,) bool, of which joints the data contract takes radians, as their names hold "joint".
        rest: reads a state that begins with the hand's pose.
    """

    kinematics: Kinematics
    places: tuple[int, ...]
    degrees: bool
    named_joint: np.ndarray
    rest: StateReader

    @property
    def names(self) -> tuple[str, ...]:
        """Of the converted numbers."""
        return self.rest.names

    def read(self, states: np.ndarray) -> np.ndarray:
        """Recorded states (T, N) as (T, len(names)) float64: the hand's pose, the opening, then all other numbers.

        These stay as they were, but for joints in degrees whose names hold "joint": they are in radians then.

        Raises:
            LlakeyError: if numbers are not finite, or in another unit, as far as the model's limits tell.
        """
        values = states.astype(np.float64)
        recorded = values[:, self.places]
        if not np.isfinite(recorded).all():
            row = int(np.argwhere(~np.isfinite(recorded))[0][0])
            raise LlakeyError(
                f"Expected finite joints in {schema.STATE}, got {recorded[row].tolist()} in row {row}; drop the "
                "episode or correct the recording."
            )
        joints = np.where(self.kinematics.turning, np.deg2rad(recorded), recorded) if self.degrees else recorded
        self._check(recorded, joints)
        values[:, self.places] = np.where(self.named_joint, joints, recorded)
        return self.rest.read(np.concatenate((self.kinematics.poses(joints), values), axis=1))

    def _check(self, recorded: np.ndarray, joints: np.ndarray) -> None:
        low, high = self.kinematics.limits.T
        low, high = np.where(np.isfinite(low), low - _BEYOND, -_FAR), np.where(np.isfinite(high), high + _BEYOND, _FAR)
        outside = ((joints < low) | (joints > high)) & self.kinematics.turning
        if outside.any():
            row, at = (int(number) for number in np.argwhere(outside)[0])
            advice = (
                "check that its zero is the model's, and that it is no share of its travel from -100 to 100"
                if self.degrees
                else "say --joint_unit=degrees if these are degrees"
            )
            raise LlakeyError(
                f"Expected {self.kinematics.joints[at]} within its limits in {self.kinematics.path}, "
                f"{self._limits(at)}, got {recorded[row, at]:.4g} in row {row}; {advice}."
            )
        turning = recorded[:, self.kinematics.turning]
        if self.degrees and turning.size and np.abs(turning).max() <= np.pi and np.ptp(turning, axis=0).max() > 0.1:
            raise LlakeyError(
                f"Expected joints in degrees in {schema.STATE}, got none beyond {np.abs(turning).max():.3g}, as in "
                "radians; say --joint_unit=radians."
            )

    def _limits(self, at: int) -> str:
        scale, unit = (180 / np.pi, "degrees") if self.degrees else (1.0, "radians")
        low, high = self.kinematics.limits[at] * scale
        return f"{low:.4g} to {high:.4g} {unit}" if np.isfinite(low) else "at most two turns"


@dataclass(frozen=True)
class ArmModel:
    """An arm's model, and how a recording writes its joints.

    Attributes:
        path: of the URDF or MJCF file.
        tip: name of the link, body or site that is the hand.
        joint_names: of the state's numbers that are the joints from base to tip, where they are not called as in the
            model; letter case and ".pos" do not matter.
        joint_unit: one of UNITS.
    """

    path: Path
    tip: str
    joint_names: Sequence[str] | None = None
    joint_unit: str = "radians"

    def reader(
        self,
        feature: Mapping[str, Any],
        *,
        rotation: str | None = None,
        state_names: Sequence[str] | None = None,
        gripper: str | None = None,
        gripper_range: Sequence[float] = (0.0, 1.0),
    ) -> JointReader:
        """Find the joints among a recording's numbers.

        Args:
            feature: LeRobot's description of the state.
            rotation: not to be given with joints.
            state_names: names in place of those that were recorded.
            gripper: name of the number that is the gripper's opening, see :func:`state_reader`.
            gripper_range: its values when closed and when open.

        Raises:
            LlakeyError: if the model does not fit the recording, or options contradict one another.
        """
        if self.joint_unit not in UNITS:
            raise LlakeyError(
                f"Expected --joint_unit out of {', '.join(UNITS)}, got {self.joint_unit!r}; choose one of these."
            )
        if rotation is not None:
            raise LlakeyError(
                f"Expected the hand's pose from --urdf or from the state, got --urdf and --rotation={rotation}; leave "
                "one away."
            )
        given = recorded_names(feature, None, state_names)
        plain = [plain_name(name) for name in given]
        if known := [name for name, short in zip(given, plain, strict=True) if short in schema.POSE_NAMES]:
            raise LlakeyError(
                f"Expected joints alone in {schema.STATE} with --urdf, got the hand's {', '.join(known)}, too; "
                "leave --urdf away, or name them otherwise by --state_names."
            )
        kinematics = read_kinematics(self.path, self.tip)
        wanted = kinematics.joints if self.joint_names is None else tuple(self.joint_names)
        if len(wanted) != len(kinematics.joints):
            raise LlakeyError(
                f"Expected --joint_names to name the {len(kinematics.joints)} joints from base to {self.tip} "
                f"({', '.join(kinematics.joints)}), got {len(wanted)} ({', '.join(wanted)}); give one for each."
            )
        places = tuple(_place(name, plain, given, kinematics) for name in wanted)
        if len(set(places)) != len(places):
            raise LlakeyError(f"Expected different numbers as --joint_names, got {', '.join(wanted)}; name each once.")
        extended = (*schema.POSE_NAMES, *given)
        described = {"shape": (len(extended),), "names": list(extended)}
        rest = state_reader(described, gripper=gripper, gripper_range=gripper_range)
        offset = len(schema.POSE_NAMES)
        if rest.gripper is not None and rest.gripper - offset in places:
            raise LlakeyError(
                f"Expected a --tip before the gripper's joint, got {self.tip}, which {given[rest.gripper - offset]} "
                "moves; name the part that bears the gripper."
            )
        named = np.array(["joint" in given[place].lower() for place in places])
        return JointReader(kinematics, places, self.joint_unit == "degrees", named, rest)


def _place(name: str, plain: Sequence[str], given: Sequence[str], kinematics: Kinematics) -> int:
    found = [place for place, one in enumerate(plain) if one == plain_name(name)]
    if len(found) != 1:
        came = f"{name} twice" if found else f"no {name} among {', '.join(given)}"
        raise LlakeyError(
            f"Expected the joints of {kinematics.path} ({', '.join(kinematics.joints)}) among the names of "
            f"{schema.STATE}, got {came}; give --joint_names=[...], the recorded names from base to tip."
        )
    return found[0]
