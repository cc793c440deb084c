"""A training aid: where the gripper is and where it will be at the next keyframe, read off the language model."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from lerobot_llakey import schema

UNIT_METRES = 0.2
"""Positions are regressed in this unit, which makes them about as large as the gripper's 0 and 1."""


class KeyframeHead(nn.Module):
    """Regresses position and gripper, now and at the next keyframe, from the hidden state that starts an answer.

    Words tell a fresh network little about geometry: a dozen tokens a sample, most of them the same. These eight
    numbers make it look at the gripper and at the object that the task names. Nothing of it is used after training.

    Args:
        width: channels of the language model.
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.linear = nn.Linear(width, 8)

    def loss(self, hidden: Tensor, hand: Tensor, action: Tensor) -> Tensor:
        """Smooth L1 loss of each sample (B,).

        Args:
            hidden: (B, width) the language model's output at the last token of the prompt.
            hand: (B, 8) as in the data contract.
            action: (B, 9) as in the data contract.
        """
        numbers = [
            part
            for row in (hand, action)
            for part in (row[:, schema.POSITION] / UNIT_METRES, row[:, schema.GRIPPER, None])
        ]
        target = torch.cat(numbers, dim=1).float()
        guess = self.linear(hidden.to(self.linear.weight.dtype)).float()
        return functional.smooth_l1_loss(guess, target, beta=0.1, reduction="none").mean(dim=1)
