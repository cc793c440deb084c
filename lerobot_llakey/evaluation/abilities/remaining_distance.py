"""How far the hand still had to go in a frame between keyframes.

Just before a keyframe a frame looks like the one at it, whose right answer is the next instruction; what an error
correction is worth shows where there is still a way to go.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import torch

from lerobot_llakey import schema

_EDGES = (0.01, 0.05, 0.20)
"""Metres."""
REMAINING_DISTANCES = ("below 1 cm", "1 to 5 cm", "5 to 20 cm", "above 20 cm")


def remaining_distances(batch: dict[str, Any], hand: Sequence[int]) -> list[str]:
    """How far each frame's hand is from the keyframe it moves to, as one of :data:`REMAINING_DISTANCES`.

    Args:
        batch: as a dataset gives it, in the data contract; without state or action nothing is known ("" each).
        hand: where the hand stands in the state, see :func:`hand.hand_columns`; without it nothing is known either.
    """
    if not hand or schema.STATE not in batch or schema.ACTION not in batch:
        return [""] * len(batch[schema.INSTRUCTION])
    place = batch[schema.STATE][:, list(hand[:3])].float()
    distances = torch.linalg.vector_norm(place - batch[schema.ACTION][:, schema.POSITION].float(), dim=1)
    return [
        REMAINING_DISTANCES[index] for index in torch.bucketize(distances, torch.tensor(_EDGES), right=True).tolist()
    ]
