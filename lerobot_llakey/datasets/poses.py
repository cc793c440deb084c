"""A recording's state as the data contract has it: the hand's pose with a quaternion, the opening, further numbers.

Recorders write rotations in many ways. Where the names of the state's numbers tell which, they decide; where they do
not (``rx, ry, rz`` is a rotation vector on one arm and Euler angles on another; some states have no names), the
person says it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.hand import OPENINGS, names_of, plain_name

_XYZ = schema.POSE_NAMES[:3]
_ENTRY = re.compile(r"(?P<matrix>.*?)_?(?P<row>[0-3])[_,]?(?P<column>[0-3])[\])]?")
_ENTRIES = tuple(f"m{row}{column}" for row in range(4) for column in range(4))
_AMBIGUOUS = ("rx", "ry", "rz")
_IN_RADIANS = ("rotation_vector", "euler")
_MOST_TURNED = 2 * np.pi + 0.1
_RIGID = 0.02
"""By how much the rows of a recorded rotation matrix may differ from unit length; they are rounded."""


def _matrices(entries: np.ndarray) -> Rotation:
    matrices = entries.reshape(-1, 4, 4)[:, :3, :3]
    square = np.abs(matrices @ np.swapaxes(matrices, 1, 2) - np.eye(3)).max(axis=(1, 2))
    wrong = ~((square < _RIGID) & (np.linalg.det(matrices) > 0))
    if wrong.any():
        row = int(wrong.argmax())
        raise LlakeyError(
            f"Expected rigid matrices of the hand, row by row, in {schema.STATE}, got "
            f"{matrices[row].round(3).tolist()} as the rotation of row {row}; "
            "give hand-to-base matrices that are not transposed or scaled."
        )
    return Rotation.from_matrix(matrices)


_FORMS: dict[str, tuple[str, ...]] = {
    "quaternion": ("qx", "qy", "qz", "qw"),
    "quaternion_wxyz": ("qw", "qx", "qy", "qz"),
    "rotation_vector": ("wx", "wy", "wz"),
    "euler": ("roll", "pitch", "yaw"),
    "euler_degrees": ("roll", "pitch", "yaw"),
    "matrix": _ENTRIES,
}
"""Ways to write a rotation, with the names of their numbers in the order of a state without names."""
_READ: dict[str, Callable[[np.ndarray], Rotation]] = {
    "rotation_vector": Rotation.from_rotvec,
    "euler": lambda angles: Rotation.from_euler("xyz", angles),
    "euler_degrees": lambda angles: Rotation.from_euler("xyz", angles, degrees=True),
    "matrix": _matrices,
}
ROTATIONS = tuple(_FORMS)
"""What ``--rotation`` may say. Rotation vectors and Euler angles are in radians; Euler angles turn about the base's x
axis (roll), then its y axis (pitch), then its z axis (yaw)."""


@dataclass(frozen=True)
class StateReader:
    """Where a recorded state's numbers stand, and what they mean.

    Attributes:
        names: of the converted numbers: schema.POSE_NAMES, "gripper_opening" where there is a gripper, further ones.
        position: places of x, y and z.
        rotation: places of the rotation's numbers, in the order of its form.
        form: one of ROTATIONS, "quaternion" for either order.
        gripper: place of the opening, None without a gripper.
        further: places of the further numbers.
        opening_range: what counts as closed and as open.
    """

    names: tuple[str, ...]
    position: tuple[int, ...]
    rotation: tuple[int, ...]
    form: str
    gripper: int | None
    further: tuple[int, ...]
    opening_range: tuple[float, float]

    def read(self, states: np.ndarray) -> np.ndarray:
        """Recorded states (T, N) as (T, len(names)) float64; quaternions of any sign, openings 0 closed to 1 open.

        Numbers that are not finite and quaternions of no length stay as they are, to be found by the checks.

        Raises:
            LlakeyError: if a matrix is not rigid, or angles are in degrees.
        """
        values = states.astype(np.float64)
        quaternion = values[:, self.rotation]
        if self.form != "quaternion":
            usable = np.isfinite(quaternion).all(axis=1)
            numbers, quaternion = quaternion[usable], np.full((len(values), 4), np.nan)
            if self.form in _IN_RADIANS and np.abs(numbers).max(initial=0.0) > _MOST_TURNED:
                raise LlakeyError(
                    f"Expected the hand's rotation in radians in {schema.STATE}, got {np.abs(numbers).max():.4g}; say "
                    "--rotation=euler_degrees if these are Euler angles in degrees, else convert them."
                )
            quaternion[usable] = _READ[self.form](numbers).as_quat()
        parts = [values[:, self.position], quaternion]
        if self.gripper is not None:
            closed, opened = self.opening_range
            parts.append((values[:, [self.gripper]] - closed) / (opened - closed))
        return np.concatenate((*parts, values[:, self.further]), axis=1)


def state_reader(
    feature: Mapping[str, Any],
    *,
    rotation: str | None = None,
    state_names: Sequence[str] | None = None,
    gripper: str | None = None,
    gripper_range: Sequence[float] = (0.0, 1.0),
) -> StateReader:
    """Find out how a recording writes the hand's pose.

    Args:
        feature: LeRobot's description of the state.
        rotation: one of ROTATIONS where the names do not tell; of a state without names, it also says that the first
            numbers are the position and this rotation (of a matrix, the first sixteen are the matrix).
        state_names: names in place of those that were recorded.
        gripper: name of the number that is the gripper's opening, where it is not one of hand.OPENINGS.
        gripper_range: the values when closed and when open.

    Raises:
        LlakeyError: if the names do not tell, or contradict the options.
    """
    if rotation is not None and rotation not in _FORMS:
        raise LlakeyError(f"Expected --rotation out of {', '.join(ROTATIONS)}, got {rotation!r}; choose one of these.")
    closed, opened = _range(gripper_range)
    given = recorded_names(feature, rotation, state_names)
    plain = [plain_name(name) for name in given]
    form, turn = _rotation(plain, given, rotation)
    in_matrix = turn[3:12:4]
    position = in_matrix if form == "matrix" else tuple(_place(plain, name, given) for name in _XYZ)
    place = _gripper(plain, given, gripper)
    hand = {*position, *turn, place}
    further = tuple(index for index in range(len(given)) if index not in hand)
    names = (*schema.POSE_NAMES, *(schema.HAND_NAMES[7:] if place is not None else ()), *(given[at] for at in further))
    return StateReader(names, position, turn, form, place, further, (closed, opened))


def _range(gripper_range: Sequence[float]) -> tuple[float, float]:
    if len(gripper_range) != 2 or not np.isfinite(gripper_range).all() or gripper_range[0] == gripper_range[1]:
        raise LlakeyError(
            f"Expected --gripper_range as [closed, open], got {list(gripper_range)}; give two numbers, as in [0,100]."
        )
    return float(gripper_range[0]), float(gripper_range[1])


def recorded_names(feature: Mapping[str, Any], rotation: str | None, state_names: Sequence[str] | None) -> list[str]:
    """The names of a recorded state's numbers; see :func:`state_reader`.

    Raises:
        LlakeyError: if there is not one for each.
    """
    count = int(np.prod(tuple(feature.get("shape") or (0,))))
    names = list(state_names) if state_names is not None else names_of(feature)
    if state_names is None and len(names) != count and rotation is not None:
        first = _FORMS[rotation] if rotation == "matrix" else (*_XYZ, *_FORMS[rotation])
        names = [*first, *(f"number_{place}" for place in range(len(first), count))]
    if len(names) != count:
        got = f"{len(names)} names ({', '.join(names)})" if names else "none"
        raise LlakeyError(
            f"Expected a name for each of the {count} numbers of {schema.STATE}, got {got}; give "
            "--state_names=[x,y,z,qx,qy,qz,qw,gripper_opening,joint_1,...] as they were recorded."
        )
    return names


def _rotation(plain: Sequence[str], given: Sequence[str], wanted: str | None) -> tuple[str, tuple[int, ...]]:
    """The rotation's form, and the places of its numbers."""
    found: dict[str, tuple[int, ...]] = {}
    for form in ("quaternion", "rotation_vector", "euler"):
        if set(_FORMS[form]) <= set(plain):
            found[form] = tuple(_place(plain, name, given) for name in _FORMS[form])
    matrix = _matrix(plain)
    if matrix:
        found["matrix"] = matrix
    ambiguous = set(_AMBIGUOUS) <= set(plain)
    kind = "" if wanted is None else wanted.removesuffix("_wxyz").removesuffix("_degrees")
    if ambiguous and kind in ("rotation_vector", "euler"):
        found = {kind: tuple(_place(plain, name, given) for name in _AMBIGUOUS)}
    if wanted is not None:
        found = {form: places for form, places in found.items() if form == kind}
    if len(found) == 1:
        form, places = next(iter(found.items()))
        return (wanted if wanted == "euler_degrees" else form), places
    if ambiguous and not found:
        wrong, advice = "rx, ry, rz", "say which by --rotation=rotation_vector or --rotation=euler"
    elif found:
        wrong, advice = " and ".join(found), "say which to take by --rotation"
    else:
        wrong = f"only {', '.join(given)}" + (f" with --rotation={wanted}" if wanted else "")
        advice = "name the numbers by --state_names or their form by --rotation, or give --urdf and --tip for joints"
    raise LlakeyError(
        f"Expected the hand's rotation among the names of {schema.STATE} (qx, qy, qz, qw in any order; wx, wy, wz; "
        f"roll, pitch, yaw; or the sixteen m00 to m33), got {wrong}; {advice}."
    )


def _matrix(plain: Sequence[str]) -> tuple[int, ...]:
    """Places of the sixteen entries of a matrix, row by row; none where the names do not tell."""
    places: dict[str, dict[tuple[str, str], int]] = {}
    for place, name in enumerate(plain):
        match = _ENTRY.fullmatch(name)
        if match:
            places.setdefault(match["matrix"], {})[match["row"], match["column"]] = place
    whole = [entries for entries in places.values() if len(entries) == 16]
    return tuple(whole[0][key] for key in sorted(whole[0])) if len(whole) == 1 else ()


def _place(plain: Sequence[str], name: str, given: Sequence[str]) -> int:
    found = [place for place, one in enumerate(plain) if one == name]
    if len(found) != 1:
        came = "it twice" if found else f"only {', '.join(given)}"
        raise LlakeyError(
            f"Expected the hand's {name!r} among the names of {schema.STATE}, got {came}; name the numbers by "
            "--state_names."
        )
    return found[0]


def _gripper(plain: Sequence[str], given: Sequence[str], wanted: str | None) -> int | None:
    if wanted is None:
        return next((place for place, name in enumerate(plain) if name in OPENINGS), None)
    if wanted not in given:
        raise LlakeyError(
            f"Expected --gripper to name a number of {schema.STATE}, got {wanted!r}; choose one of {', '.join(given)}."
        )
    return list(given).index(wanted)
