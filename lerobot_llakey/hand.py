"""Where the hand's pose and the gripper's opening stand among a state's named numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch
from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError

_PREFIXES = ("ee", "eef", "tcp", "hand", "end_effector")
OPENINGS = ("gripper_opening", "gripper", "gripper_pos", "gripper_position", "gripper_width")
"""Plain names of a gripper's opening."""


def names_of(feature: Mapping[str, Any]) -> list[str]:
    """The names of a feature's numbers, which some recorders write in groups: ``{"motors": [...]}``."""
    names = feature.get("names")
    if isinstance(names, Mapping):
        names = [name for group in names.values() for name in (group if isinstance(group, list | tuple) else [group])]
    return [] if names is None or isinstance(names, str) else [str(name) for name in names]


def hand_columns(names: Sequence[str], key: str = schema.STATE) -> tuple[int, ...]:
    """Places of x, y, z, qx, qy, qz, qw and the gripper's opening among a state's names.

    Names may carry a prefix of the hand ("ee.x", "tcp_x") and a suffix ".pos"; the opening may be missing.

    Args:
        names: of the state's numbers.
        key: of the column, for the error.

    Returns:
        Seven places, and an eighth where there is a gripper.

    Raises:
        LlakeyError: naming the column if a number of the pose is missing or named twice.
    """
    plain = [plain_name(name) for name in names]
    places: list[int] = []
    for wanted in schema.POSE_NAMES:
        found = [place for place, name in enumerate(plain) if name == wanted]
        if len(found) != 1:
            came = "it twice" if found else f"only {', '.join(names) or 'numbers without names'}"
            raise LlakeyError(
                f"Expected the hand's {wanted!r} among the names of {key}, got {came}; name the columns "
                f"{', '.join(schema.POSE_NAMES)} in any order, or convert the pose with `llakey annotate`."
            )
        places += found
    openings = [place for place, name in enumerate(plain) if name in OPENINGS]
    return (*places, *openings[:1])


def further_columns(names: Sequence[str]) -> tuple[int, ...]:
    """Places of a state's numbers that are not the hand's, such as joint angles."""
    hand = hand_columns(names)
    return tuple(place for place in range(len(names)) if place not in hand)


def joint_columns(names: Sequence[str]) -> list[int]:
    """Places of a state's joint angles in radians: those further numbers whose names hold "joint"."""
    return [place for place in further_columns(names) if "joint" in names[place].lower()]


def read_hand[Array: (np.ndarray, Tensor)](states: Array, columns: Sequence[int]) -> Array:
    """The hands (..., 8) in states (..., N): position, quaternion, opening; without a gripper, it counts as open.

    Args:
        states: numbers as recorded.
        columns: as :func:`hand_columns` gives them.
    """
    hand = states[..., list(columns)]
    if len(columns) == schema.HAND_DIM:
        return hand
    if isinstance(hand, Tensor):
        return torch.cat((hand, torch.ones_like(hand[..., :1])), dim=-1)
    return np.concatenate((hand, np.ones_like(hand[..., :1])), axis=-1)


def plain_name(name: str) -> str:
    """A number's name in lower case, without a prefix of the hand ("ee.", "tcp_") and the suffix ".pos"."""
    plain = name.lower().removesuffix(".pos")
    for prefix in _PREFIXES:
        for joint in (".", "_"):
            plain = plain.removeprefix(f"{prefix}{joint}")
    return plain
