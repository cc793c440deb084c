"""What both policies are handed in a batch besides words, and what they hand back: held against the data contract.

A number that is not finite would otherwise reach every weight within one step of training, without a word.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import torch
from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.hand import read_hand
from lerobot_llakey.schema import FARTHEST, UNIT_TOLERANCE

OPENING = (-0.1, 1.1)
"""What a gripper's opening may be; measured ones overshoot 0 and 1 a little."""
COLOUR = (-0.1, 1.1)
"""What a colour may be; resizing overshoots 0 and 1 a little."""


def read_numbers(batch: Mapping[str, Any], key: str, shape: Sequence[int | str], rows: int | None = None) -> Tensor:
    """The numbers (B, ...) of a key.

    Args:
        batch: what a loader or an environment gives.
        key: of the numbers.
        shape: of one row; a name stands for a size that may be any.
        rows: B, where another key has told it.

    Raises:
        LlakeyError: naming the key if it is missing, holds no numbers, or has another shape.
    """
    if key not in batch:
        raise LlakeyError(f"Expected {key} in the batch, got {', '.join(sorted(batch)) or 'nothing'}; add it.")
    value = batch[key]
    if not isinstance(value, Tensor):
        raise LlakeyError(f"Expected numbers in {key}, got {type(value).__name__}; give it as a tensor.")
    sizes = ("batch" if rows is None else rows, *shape)
    alike = value.ndim == len(sizes) and all(
        isinstance(size, str) or size == came for size, came in zip(sizes, value.shape, strict=True)
    )
    if not alike:
        wanted = ", ".join(map(str, sizes))
        raise LlakeyError(f"Expected {key} of shape ({wanted}), got {tuple(value.shape)}; check the feature.")
    return value


def read_images(batch: Mapping[str, Any], keys: Sequence[str]) -> list[Tensor]:
    """RGB images (B, 3, H, W) in float, 0..1: those in uint8 are divided by 255.

    Args:
        batch: what a loader or an environment gives.
        keys: of the images.

    Raises:
        LlakeyError: naming the key and the row if an image is missing, has another shape, is in whole numbers of
            another kind, or holds colours outside 0..1.
    """
    if missing := [key for key in keys if key not in batch]:
        given = sorted(name for name in batch if name.startswith(schema.image_key("")))
        raise LlakeyError(
            f"Expected the images {', '.join(keys)} in the batch, got {', '.join(given) or 'none'}; add "
            f"{', '.join(missing)}."
        )
    images: list[Tensor] = []
    for key in keys:
        image = read_numbers(batch, key, (3, "height", "width"), len(images[0]) if images else None)
        if image.dtype is torch.uint8:
            images.append(image.float() / 255)
        elif image.is_floating_point():
            images.append(image)
        else:
            raise LlakeyError(
                f"Expected {key} in floats from 0 to 1 or in uint8, got {_name(image)}; convert the images."
            )
    _check_colours(images, keys)
    return images


def read_hands(batch: Mapping[str, Any], columns: Sequence[int], rows: int | None = None) -> Tensor:
    """The hands (B, 8) in the states of a batch, with one sign of the two that a quaternion may have.

    Args:
        batch: what a loader or an environment gives.
        columns: where the hand stands among the state's numbers, see :func:`hand.hand_columns`.
        rows: B, where another key has told it.

    Raises:
        LlakeyError: see :func:`read_numbers` and :func:`check_poses`.
    """
    states = read_numbers(batch, schema.STATE, ("numbers",), rows)
    if states.shape[1] <= max(columns):
        raise LlakeyError(
            f"Expected at least {max(columns) + 1} numbers in {schema.STATE}, got {states.shape[1]}; give those of "
            "policy.state_names in their order."
        )
    hands = read_hand(states, columns)
    check_poses(schema.STATE, hands)
    quaternion = hands[:, schema.QUATERNION]
    x, w = quaternion[:, :1], quaternion[:, 3:]
    sign = torch.where(torch.where(w == 0, x, w) < 0, -1.0, 1.0)
    return torch.cat((hands[:, schema.POSITION], quaternion * sign.to(hands), hands[:, schema.GRIPPER :]), dim=1)


def read_actions(batch: Mapping[str, Any], rows: int | None = None) -> Tensor:
    """The actions (B, 9) of a batch; see :func:`read_numbers` and :func:`check_poses` for what is refused."""
    actions = read_numbers(batch, schema.ACTION, (schema.ACTION_DIM,), rows)
    check_poses(schema.ACTION, actions)
    return actions


def check_poses(key: str, rows: Tensor) -> None:
    """Check the position, quaternion and gripper of hands (B, 8) or actions (B, 9).

    Raises:
        LlakeyError: naming the key and the batch row if a number is not finite, the position is out of any arm's reach,
            the quaternion is not of unit length, or the gripper is not within 0..1.
    """
    columns = rows[:, : schema.GRIPPER + 1].float()
    position, length = columns[:, schema.POSITION], columns[:, schema.QUATERNION].norm(dim=1)
    gripper = columns[:, schema.GRIPPER]
    # Compared so that NaN is never right.
    right = torch.stack(
        (
            (position.abs() <= FARTHEST).all(dim=1),
            (length - 1).abs() <= UNIT_TOLERANCE,
            (gripper >= OPENING[0]) & (gripper <= OPENING[1]),
        )
    )
    if right.all():
        return
    kind, row = (int(index) for index in (~right).nonzero()[0])
    part = (schema.POSITION, schema.QUATERNION, slice(schema.GRIPPER, schema.GRIPPER + 1))[kind]
    expected, advice = (
        ("a position in metres", f"give one within {FARTHEST:g} m of the base"),
        ("a unit quaternion xyzw", "normalise it, or correct the pose"),
        ("a gripper from 0 (closed) to 1 (open)", "scale it to that range"),
    )[kind]
    raise LlakeyError(f"Expected {expected} in {key}, got {_numbers(columns[row, part])} in batch row {row}; {advice}.")


def check_finite(key: str, values: Tensor) -> None:
    """Check numbers (B, ...), such as velocities.

    Raises:
        LlakeyError: naming the key and the batch row if one is not finite.
    """
    right = values.isfinite().flatten(1).all(dim=1)
    if not right.all():
        row = int((~right).nonzero()[0])
        raise LlakeyError(
            f"Expected finite numbers in {key}, got {_numbers(values[row].flatten())} in batch row {row}; correct the "
            "column."
        )


def check_at_least_zero(key: str, values: Tensor) -> None:
    """Check numbers (B, ...), such as a step or a weight.

    Raises:
        LlakeyError: naming the key and the batch row if one is negative or not finite.
    """
    right = ((values >= 0) & values.isfinite()).flatten(1).all(dim=1)
    if not right.all():
        row = int((~right).nonzero()[0])
        raise LlakeyError(
            f"Expected {key} of 0 or more, got {_numbers(values[row].flatten())} in batch row {row}; correct the "
            "column."
        )


def check_actions(actions: Tensor) -> Tensor:
    """Actions (B, 9) that are to be carried out, if they are finite.

    Raises:
        LlakeyError: naming the batch row if one is not: the robot must not get it.
    """
    right = actions.isfinite().all(dim=1)
    if not right.all():
        row = int((~right).nonzero()[0])
        raise LlakeyError(
            f"Expected the policy to answer with finite numbers, got {_numbers(actions[row])} in batch row {row}; its "
            "weights are damaged: give another checkpoint."
        )
    return actions


def _check_colours(images: Sequence[Tensor], keys: Sequence[str]) -> None:
    lows = torch.stack([image.flatten(1).amin(dim=1) for image in images])  # (V, B)
    highs = torch.stack([image.flatten(1).amax(dim=1) for image in images])
    wrong = ~((lows >= COLOUR[0]) & (highs <= COLOUR[1]))  # so that NaN is wrong
    if wrong.any():
        view, row = (int(index) for index in wrong.nonzero()[0])
        raise LlakeyError(
            f"Expected colours from 0 to 1 in {keys[view]}, got {lows[view, row].item():g} to "
            f"{highs[view, row].item():g} in batch row {row}; divide them by 255 or take the normalisation out."
        )


def _name(values: Tensor) -> str:
    return str(values.dtype).removeprefix("torch.")


def _numbers(values: Tensor) -> list[float]:
    return [float(f"{number:.4g}") for number in values.tolist()]
